use crate::{Cancel, Cancelled};
use glam::{DMat3, DMat4, DVec3};

/// An ellipsoid: the points p with (p - center)^T shape^-1 (p - center) at most 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipsoid {
    pub center: DVec3,
    /// The sum of the outer products of the semi-axes.
    pub shape: DMat3,
}

/// Tolerance on how far beyond the ellipsoid a point may lie, as a share of its squared distance in the
/// metric of the ellipsoid; from the authors' code.
const TOLERANCE: f64 = 0.01;

impl Ellipsoid {
    /// Returns the smallest ellipsoid around points that do not lie in a plane, up to the tolerance
    /// (Khachiyan 1996). Each point has a weight; that of the point farthest out grows.
    pub fn around(points: &[DVec3], cancel: &Cancel) -> Result<Self, Cancelled> {
        const D: f64 = 3.0;
        let weight = 1.0 / points.len() as f64;
        // The weighted sum of the outer products of (p, 1), which is all that is needed of the weights.
        let mut sums = points.iter().fold(DMat4::ZERO, |sum, &point| sum + outer(point) * weight);
        loop {
            cancel.check()?;
            let (farthest, distance) = farthest(points, &sums.inverse());
            if distance <= (1.0 + TOLERANCE) * (D + 1.0) {
                let center = sums.w_axis.truncate();
                let squares = DMat3::from_mat4(sums);
                let of_center = DMat3::from_cols(center * center.x, center * center.y, center * center.z);
                return Ok(Self { center, shape: (squares - of_center) * D });
            }
            let step = (distance - D - 1.0) / ((D + 1.0) * (distance - 1.0));
            sums = sums * (1.0 - step) + outer(farthest) * step;
        }
    }

    /// Scales the coordinates by `size` and moves the result by `offset`.
    pub fn scaled(self, size: f64, offset: DVec3) -> Self {
        Self { center: self.center * size + offset, shape: self.shape * (size * size) }
    }
}

/// The first point p with the largest q^T inverse q, q = (p, 1), and that value.
fn farthest(points: &[DVec3], inverse: &DMat4) -> (DVec3, f64) {
    let distance = |point: &DVec3| point.extend(1.0).dot(*inverse * point.extend(1.0));
    let all = points.iter().map(|point| (*point, distance(point)));
    all.fold((DVec3::ZERO, 0.0), |best, next| if next.1 > best.1 { next } else { best })
}

fn outer(point: DVec3) -> DMat4 {
    let q = point.extend(1.0);
    DMat4::from_cols(q * q.x, q * q.y, q * q.z, q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use glam::DQuat;

    fn around(points: &[DVec3]) -> Ellipsoid {
        Ellipsoid::around(points, &Cancel::default()).unwrap()
    }

    /// Squared distance from the centre in the metric of the ellipsoid.
    fn distance(ellipsoid: &Ellipsoid, point: DVec3) -> f64 {
        let offset = point - ellipsoid.center;
        offset.dot(ellipsoid.shape.inverse() * offset)
    }

    #[test]
    fn of_points_on_an_ellipsoid_it_is_that_ellipsoid() {
        let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1));
        let axes = DVec3::new(5.0, 2.0, 1.0);
        let mut random = Random::new(1, 0);
        let center = DVec3::new(20.0, -7.0, 3.0);
        let points: Vec<DVec3> =
            (0..2000).map(|_| center + turn * (axes * random.in_cube().normalize())).collect();
        let found = around(&points);
        let shape = turn * DMat3::from_diagonal(axes * axes) * turn.transpose();
        assert!(found.center.distance(center) < 0.1);
        let is_near = |(a, b): (f64, f64)| (a - b).abs() < 0.05 * 25.0;
        assert!(found.shape.to_cols_array().into_iter().zip(shape.to_cols_array()).all(is_near));
        assert!((found.shape.determinant() / shape.determinant() - 1.0).abs() < 0.05);
    }

    /// The slow twin: ellipsoids of any shape around the points, none of which is smaller.
    #[test]
    fn no_other_ellipsoid_around_the_points_is_smaller() {
        let mut random = Random::new(2, 0);
        for n in [4, 7, 30] {
            let points: Vec<DVec3> = (0..n).map(|_| random.in_cube() * DVec3::new(9.0, 4.0, 2.0)).collect();
            let found = around(&points);
            assert!(points.iter().all(|point| distance(&found, *point) < 1.0 + 2.0 * TOLERANCE));
            for _ in 0..2000 {
                let scale = 10.0_f64.powf(random.range(-3.0, 0.0));
                let mut vector = || random.in_cube() * scale;
                let change = DMat3::IDENTITY + DMat3::from_cols(vector(), vector(), vector());
                let other = Ellipsoid {
                    center: found.center + vector() * 3.0,
                    shape: change * found.shape * change.transpose(),
                };
                let reach = points.iter().map(|point| distance(&other, *point)).fold(0.0, f64::max);
                let volume_sq = other.shape.determinant() * reach.powi(3);
                assert!(volume_sq > found.shape.determinant() * (1.0 - TOLERANCE).powi(4), "{scale}");
            }
        }
    }
}
