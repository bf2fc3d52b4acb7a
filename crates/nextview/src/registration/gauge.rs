//! The common pose of all frames. Their surfaces determine only their relative poses; the given poses
//! determine the common one.

use super::RegistrationConfig;
use super::joint::JointView;
use crate::geometry::{Eigen, Pose};
use glam::{DQuat, DVec3};

/// Metres that weigh as much as a turn by a radian: beyond this limit, rotations alone decide, and below its
/// inverse, positions do.
const LONGEST_ARM: f64 = 1e3;

/// Returns the common motion of all views that best matches the given poses; the identity without points.
///
/// The rotation is the most likely one if the given camera poses have independent, normally distributed
/// errors of position and rotation, in proportion to their uncertainties. Points of the object determine it
/// less well: a position error shifts the side of the object that a camera sees, and shifts of its sides turn
/// the object.
///
/// The translation moves the middle of all points to where the given poses put it: poses from markers around
/// the object, or from its surface, have rotation errors around the object rather than around the camera.
pub(super) fn motion_to_given(views: &[JointView], config: &RegistrationConfig) -> Pose {
    let pairs: Vec<_> = views.iter().flat_map(JointView::placed_and_given).collect();
    if pairs.is_empty() {
        return Pose::IDENTITY;
    }
    let turn = motion_of_cameras(views.iter().map(JointView::found_and_given), config).rotation();
    let [from, to] = means(&pairs);
    Pose::new(turn, to - turn * from).expect("means of finite points are finite")
}

/// Returns the most likely motion of the cameras from their found to their true poses, given pairs of found
/// and given poses.
fn motion_of_cameras(poses: impl Iterator<Item = [Pose; 2]>, config: &RegistrationConfig) -> Pose {
    let arm = config.position_uncertainty / config.rotation_uncertainty;
    let arm = arm.clamp(LONGEST_ARM.recip(), LONGEST_ARM);
    // Six points around a camera, s away: errors t and w of its pose move them by 6 t^2 + 4 s^2 w^2, which
    // must be proportional to t^2 + (arm w)^2.
    let s = 1.5_f64.sqrt() * arm;
    let around = DVec3::AXES.map(|axis| s * axis);
    let around = around.into_iter().flat_map(|point| [point, -point]);
    let points =
        poses.flat_map(|pair| around.clone().map(move |point| pair.map(|pose| pose.transform_point(point))));
    motion_between(&points.collect::<Vec<_>>())
}

/// The means of the first and of the second points.
fn means(points: &[[DVec3; 2]]) -> [DVec3; 2] {
    [0, 1].map(|side| points.iter().map(|pair| pair[side]).sum::<DVec3>() / points.len().max(1) as f64)
}

/// Returns the motion that brings the first points closest to the second ones: least squares in closed form
/// (Horn, J. Opt. Soc. Am. A 1987).
fn motion_between(points: &[[DVec3; 2]]) -> Pose {
    let [from, to] = means(points);
    // Sums of the products of all coordinates.
    let mut s = [[0.0; 3]; 3];
    for pair in points {
        let (a, b) = ((pair[0] - from).to_array(), (pair[1] - to).to_array());
        (0..3).for_each(|i| (0..3).for_each(|j| s[i][j] += a[i] * b[j]));
    }
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = s;
    // Horn's matrix with the opposite sign: the eigenvector of its smallest eigenvalue is the rotation, w
    // first.
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
    fn errors_of_poses_are_least_as_uncertain_as_these_are() {
        let mut random = Random::new(9, 0);
        for (position_uncertainty, rotation_uncertainty) in [(0.05, 0.17), (0.002, 0.1), (0.1, 0.01)] {
            let config = RegistrationConfig {
                position_uncertainty,
                rotation_uncertainty,
                ..RegistrationConfig::default()
            };
            let mut pose = |size: f64, length: f64| {
                let turn = DQuat::from_scaled_axis(size * random.in_cube());
                Pose::new(turn, length * random.in_cube()).unwrap()
            };
            let poses: Vec<_> = (0..8)
                .map(|_| {
                    let found = pose(3.0, 0.5);
                    [found, found * pose(0.01, 0.01)]
                })
                .collect();
            let cost = |motion: &Pose| {
                let off = |[found, given]: &[Pose; 2]| {
                    let off = given.inverse() * *motion * *found;
                    let turn = off.rotation().to_scaled_axis();
                    let turn = if off.rotation().w < 0.0 { (-off.rotation()).to_scaled_axis() } else { turn };
                    (off.translation() / position_uncertainty).length_squared()
                        + (turn / rotation_uncertainty).length_squared()
                };
                poses.iter().map(off).sum::<f64>()
            };
            let best = motion_of_cameras(poses.iter().copied(), &config);
            for axis in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
                let turned = Pose::new(DQuat::from_scaled_axis(1e-3 * axis), DVec3::ZERO).unwrap();
                let shifted = Pose::new(DQuat::IDENTITY, 1e-3 * axis).unwrap();
                assert!(cost(&best) < cost(&(turned * best)), "{config:?}, a turn about {axis}");
                assert!(cost(&best) < cost(&(shifted * best)), "{config:?}, a shift along {axis}");
            }
        }
    }

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
