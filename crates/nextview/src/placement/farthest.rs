use crate::Cancel;
use crate::geometry::{Aabb, BoxTree, Search};
use glam::DVec3;

/// Finds the farthest point in a direction.
pub(super) struct Farthest(BoxTree<1>);

/// The farthest point so far.
struct FarthestPoint {
    direction: DVec3,
    along: f64,
    number: usize,
}

impl Farthest {
    /// Creates the search among finite points.
    pub fn new(points: impl IntoIterator<Item = DVec3>) -> Self {
        let points = points.into_iter().map(|point| [point]);
        Self(BoxTree::new(points, &Cancel::default()).expect("nobody cancels"))
    }

    /// The largest distance along the direction and its point, the last on ties; `None` if empty.
    pub fn along(&self, direction: DVec3) -> Option<(f64, usize)> {
        let mut best = FarthestPoint { direction, along: f64::NEG_INFINITY, number: 0 };
        self.0.search(&mut best);
        (!self.0.is_empty()).then_some((best.along, best.number))
    }
}

impl Search<1> for FarthestPoint {
    /// The negated distance of the box's farthest corner. Products and sums round alike for it and for
    /// points, so no point is farther.
    fn rank(&self, [bounds]: &[Aabb; 1]) -> f64 {
        -bounds.most_along(self.direction)
    }

    fn limit(&self) -> f64 {
        -self.along
    }

    fn offer(&mut self, [point]: &[DVec3; 1], number: usize) {
        let along = point.dot(self.direction);
        if along > self.along || along == self.along && number > self.number {
            (self.along, self.number) = (along, number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Whole numbers give many ties.
    fn vector() -> impl Strategy<Value = DVec3> {
        let tied = prop::array::uniform3(-3..4).prop_map(|v| v.map(f64::from));
        prop_oneof![tied, prop::array::uniform3(-3.0..3.0)].prop_map(DVec3::from_array)
    }

    proptest! {
        /// The slow twin: all points.
        #[test]
        fn finds_the_last_of_the_farthest(points in prop::collection::vec(vector(), 0..100), direction in vector()) {
            // Zeros of both signs are equal.
            let along = points.iter().map(|point| point.dot(direction) + 0.0).zip(0..);
            let expected = along.max_by(|a: &(f64, usize), b| a.0.total_cmp(&b.0));
            prop_assert_eq!(Farthest::new(points).along(direction), expected);
        }
    }
}
