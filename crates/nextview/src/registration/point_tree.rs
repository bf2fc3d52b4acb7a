use super::surface_points::SurfacePoint;
use crate::geometry::{Aabb, BoxTree, Search};
use crate::{Cancel, Cancelled};
use glam::DVec3;

/// Minimum cosine between the normals of two points that face the same way: 45 degrees. This excludes the
/// other side of a thin wall.
const LEAST_AGREEMENT: f64 = 0.7;

/// Nearest-neighbour search among surface points.
#[derive(Clone, Debug, Default)]
pub(super) struct PointTree(BoxTree<2>);

/// The nearest point so far.
struct BestPoint<'a> {
    to: &'a SurfacePoint,
    dist_sq: f64,
    /// The point and its number.
    nearest: Option<(SurfacePoint, usize)>,
}

impl PointTree {
    /// Builds a tree of these points, unless cancelled.
    pub fn new(points: &[SurfacePoint], cancel: &Cancel) -> Result<Self, Cancelled> {
        let items = points.iter().map(|point| [point.position, point.normal]);
        Ok(Self(BoxTree::new(items, cancel)?))
    }

    /// Returns the nearest point that faces the same way within `reach` metres; the first on ties.
    pub fn nearest(&self, to: &SurfacePoint, reach: f64) -> Option<SurfacePoint> {
        self.numbered(to, reach).map(|(point, _)| point)
    }

    fn numbered(&self, to: &SurfacePoint, reach: f64) -> Option<(SurfacePoint, usize)> {
        let mut best = BestPoint { to, dist_sq: reach * reach, nearest: None };
        self.0.search(&mut best);
        best.nearest
    }
}

/// Boxes are ranked like points, with order-preserving rounding: no point of a box is nearer or agrees
/// better.
impl Search<2> for BestPoint<'_> {
    fn rank(&self, [positions, normals]: &[Aabb; 2]) -> f64 {
        match normals.most_along(self.to.normal) >= LEAST_AGREEMENT {
            true => positions.distance_squared(self.to.position),
            false => f64::INFINITY,
        }
    }

    fn limit(&self) -> f64 {
        self.dist_sq
    }

    fn offer(&mut self, &[position, normal]: &[DVec3; 2], number: usize) {
        let dist_sq = position.distance_squared(self.to.position);
        let is_first = || self.nearest.is_none_or(|(_, first)| number < first);
        let is_nearer = dist_sq < self.dist_sq || dist_sq == self.dist_sq && is_first();
        if is_nearer && normal.dot(self.to.normal) >= LEAST_AGREEMENT {
            (self.dist_sq, self.nearest) = (dist_sq, Some((SurfacePoint { position, normal }, number)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Integers make many ties.
    fn vector() -> impl Strategy<Value = DVec3> {
        let tied = prop::array::uniform3(-3..4).prop_map(|v| v.map(f64::from));
        prop_oneof![tied, prop::array::uniform3(-3.0..3.0)].prop_map(DVec3::from_array)
    }

    fn point() -> impl Strategy<Value = SurfacePoint> {
        let normal = vector().prop_map(|normal| normal.try_normalize().unwrap_or(DVec3::Z));
        (vector(), normal).prop_map(|(position, normal)| SurfacePoint { position, normal })
    }

    proptest! {
        /// The slow twin: all points.
        #[test]
        fn finds_the_first_of_the_nearest_that_face_the_same_way(
            points in prop::collection::vec(point(), 0..200), to in point(), reach in 0..8,
        ) {
            let dist_sq = |point: &SurfacePoint| point.position.distance_squared(to.position);
            let is_pair = |point: &SurfacePoint| {
                point.normal.dot(to.normal) >= LEAST_AGREEMENT && dist_sq(point) <= (reach * reach) as f64
            };
            let pairs = points.iter().copied().zip(0..).filter(|(point, _)| is_pair(point));
            let expected = pairs.min_by(|(a, _), (b, _)| dist_sq(a).total_cmp(&dist_sq(b)));
            let tree = PointTree::new(&points, &Cancel::default()).unwrap();
            prop_assert_eq!(tree.numbered(&to, reach as f64), expected);
        }
    }
}
