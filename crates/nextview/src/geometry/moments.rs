use super::eigen::Eigen;
use glam::{DMat3, DVec3};
use std::ops::Add;

/// Largest variance across a fitted plane, as a share of the smaller variance along it. For a full disc, the
/// latter is a quarter of the squared radius, so the disc may be half as thick as it is wide: anything
/// thicker is an edge or a wire, not a plane.
const MOST_THICKNESS: f64 = 0.2;

/// Sums over points, for fitting a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    /// Number of points.
    pub n: f64,
    pub sum: DVec3,
    /// Sum of the outer products.
    pub squares: DMat3,
}

impl Moments {
    /// The sums over no points.
    pub const NONE: Self = Self { n: 0.0, sum: DVec3::ZERO, squares: DMat3::ZERO };

    /// Returns the sums over one point.
    pub fn of(point: DVec3) -> Self {
        let squares = DMat3::from_cols(point * point.x, point * point.y, point * point.z);
        Self { n: 1.0, sum: point, squares }
    }

    /// Returns the normal, of either sign, of the least-squares plane (principal components, Hoppe et al.
    /// 1992); `None` if the points do not form a plane. There must be at least one point.
    pub fn normal(&self) -> Option<DVec3> {
        let eigen = self.principal_axes();
        let across = eigen.smallest();
        let along = (0..3).filter(|i| *i != across).map(|i| eigen.values[i]).fold(f64::INFINITY, f64::min);
        let normal = DVec3::from_array(eigen.vectors[across]);
        (along > 0.0 && eigen.values[across] <= MOST_THICKNESS * along).then_some(normal)
    }

    /// Returns the direction of least variance, of either sign. There must be at least one point.
    pub fn least_axis(&self) -> DVec3 {
        let eigen = self.principal_axes();
        DVec3::from_array(eigen.vectors[eigen.smallest()])
    }

    /// Returns the principal axes and the variances along them.
    fn principal_axes(&self) -> Eigen<3> {
        let mean = self.sum / self.n;
        let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        Eigen::of((self.squares * (1.0 / self.n) - outer).to_cols_array_2d())
    }
}

impl Add for Moments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { n: self.n + other.n, sum: self.sum + other.sum, squares: self.squares + other.squares }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn normal_of(points: impl Iterator<Item = DVec3>) -> Option<DVec3> {
        points.map(Moments::of).fold(Moments::NONE, Moments::add).normal()
    }

    #[test]
    fn a_disc_has_a_normal_and_a_wire_has_none() {
        let mut random = Random::new(4, 0);
        let mut ball = || (0..50).map(|_| random.in_cube()).collect::<Vec<_>>();
        let disc = normal_of(ball().iter().map(|p| DVec3::new(p.x, p.y, 0.3 * p.z + 7.0))).unwrap();
        assert!(disc.z.abs() > 0.99, "{disc}");
        assert_eq!(normal_of(ball().into_iter()), None);
        assert_eq!(normal_of(ball().iter().map(|p| DVec3::new(p.x, 0.01 * p.y, 0.01 * p.z))), None);
        assert_eq!(normal_of([DVec3::ONE; 3].into_iter()), None);
    }
}
