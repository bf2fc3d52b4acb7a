//! The common pose of all frames. Their surfaces determine only their relative poses; the given poses
//! determine the common one.

use super::joint::View;
use crate::geometry::{Eigen, Pose};
use glam::{DQuat, DVec3};

/// The motion that brings the points of all views, where these are now, nearest to where the given poses put
/// them: least squares in closed form (Horn, J. Opt. Soc. Am. A 1987). None moves where there are no points.
pub(super) fn motion_to_given(views: &[View]) -> Pose {
    motion_between(&views.iter().flat_map(View::placed_and_given).collect::<Vec<_>>())
}

/// The motion that brings the first points nearest to the second ones.
fn motion_between(points: &[[DVec3; 2]]) -> Pose {
    let n = points.len().max(1) as f64;
    let [from, to] = [0, 1].map(|side| points.iter().map(|pair| pair[side]).sum::<DVec3>() / n);
    // Sums of the products of all coordinates.
    let mut s = [[0.0; 3]; 3];
    for pair in points {
        let (a, b) = ((pair[0] - from).to_array(), (pair[1] - to).to_array());
        (0..3).for_each(|i| (0..3).for_each(|j| s[i][j] += a[i] * b[j]));
    }
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = s;
    // Horn's matrix with the opposite sign: the eigenvector of its smallest eigenvalue is the turn, w first.
    let negated = [
        [-xx - yy - zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, -xx + yy + zz, -xy - yx, -zx - xz],
        [xz - zx, -xy - yx, xx - yy + zz, -yz - zy],
        [yx - xy, -zx - xz, -yz - zy, xx + yy - zz],
    ];
    let eigen = Eigen::of(negated);
    let [w, x, y, z] = eigen.vectors[eigen.smallest()];
    let turn = DQuat::from_xyzw(x, y, z, w).normalize();
    Pose::new(turn, to - turn * from).expect("means of finite points are finite")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    #[test]
    fn a_motion_is_found_again() {
        let mut random = Random::new(3, 0);
        for size in [0.0, 1e-6, 0.1, 3.0] {
            let turn = DQuat::from_scaled_axis(size * random.in_cube());
            let motion = Pose::new(turn, random.in_cube()).unwrap();
            let points: Vec<_> =
                (0..20).map(|_| random.in_cube()).map(|p| [p, motion.transform_point(p)]).collect();
            let found = motion_between(&points);
            let off = points.iter().map(|[from, to]| found.transform_point(*from).distance(*to));
            assert!(off.fold(0.0, f64::max) < 1e-12, "{size}");
        }
    }

    #[test]
    fn points_that_disagree_are_met_in_the_middle() {
        let points = [-0.1, 0.1].map(|off| [DVec3::X, DVec3::X + off * DVec3::Y]);
        let found = motion_between(&points);
        assert!(found.transform_point(DVec3::X).distance(DVec3::X) < 1e-12);
        assert!(motion_between(&[]).translation() == DVec3::ZERO);
    }
}
