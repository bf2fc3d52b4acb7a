use super::surface_points::SurfacePoint;
use crate::{Cancel, Cancelled};
use glam::DVec3;

/// Nearest-neighbour search among points: a k-d tree (Bentley 1975).
#[derive(Clone, Debug, Default)]
pub(super) struct PointTree {
    /// The middle of every range is its root; those before it have a lower or the same coordinate on the
    /// root's axis, those behind it a higher or the same.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    point: SurfacePoint,
    /// Number of the point; ties go to the lowest.
    number: usize,
    axis: usize,
}

/// The nearest so far.
struct Best<'a> {
    dist_sq: f64,
    node: Option<&'a Node>,
}

impl PointTree {
    /// A tree of these points, unless cancelled.
    pub fn new(points: &[SurfacePoint], cancel: &Cancel) -> Result<Self, Cancelled> {
        let node = |(number, &point): (usize, &SurfacePoint)| Node { point, number, axis: 0 };
        let mut nodes: Vec<Node> = points.iter().enumerate().map(node).collect();
        arrange(&mut nodes, cancel)?;
        Ok(Self { nodes })
    }

    /// The nearest of the points that are at most `reach` metres away and fit; the first on ties.
    pub fn nearest(
        &self,
        to: DVec3,
        reach: f64,
        fits: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<&SurfacePoint> {
        let mut best = Best { dist_sq: reach * reach, node: None };
        search(&self.nodes, to, &fits, &mut best);
        best.node.map(|node| &node.point)
    }
}

/// Halves the points along the longest side of the box around them, and so on.
fn arrange(nodes: &mut [Node], cancel: &Cancel) -> Result<(), Cancelled> {
    if nodes.len() < 2 {
        return Ok(());
    }
    cancel.check()?;
    let axis = longest_axis(nodes);
    let coordinate = |node: &Node| node.point.position[axis];
    let order = |a: &Node, b: &Node| coordinate(a).total_cmp(&coordinate(b)).then(a.number.cmp(&b.number));
    let (before, root, behind) = nodes.select_nth_unstable_by(nodes.len() / 2, order);
    root.axis = axis;
    arrange(before, cancel)?;
    arrange(behind, cancel)
}

fn longest_axis(nodes: &[Node]) -> usize {
    let positions = || nodes.iter().map(|node| node.point.position);
    let size =
        positions().fold(DVec3::NEG_INFINITY, DVec3::max) - positions().fold(DVec3::INFINITY, DVec3::min);
    size.max_position()
}

fn search<'a>(nodes: &'a [Node], to: DVec3, fits: &impl Fn(&SurfacePoint) -> bool, best: &mut Best<'a>) {
    let middle = nodes.len() / 2;
    let Some(root) = nodes.get(middle) else { return };
    best.offer(root, to, fits);
    let beyond = to[root.axis] - root.point.position[root.axis];
    let (before, behind) = (&nodes[..middle], &nodes[middle + 1..]);
    let (near, far) = if beyond < 0.0 { (before, behind) } else { (behind, before) };
    search(near, to, fits, best);
    if beyond * beyond <= best.dist_sq {
        search(far, to, fits, best);
    }
}

impl<'a> Best<'a> {
    fn offer(&mut self, node: &'a Node, to: DVec3, fits: &impl Fn(&SurfacePoint) -> bool) {
        let dist_sq = node.point.position.distance_squared(to);
        let is_first = || self.node.is_none_or(|best| node.number < best.number);
        if (dist_sq < self.dist_sq || dist_sq == self.dist_sq && is_first()) && fits(&node.point) {
            (self.dist_sq, self.node) = (dist_sq, Some(node));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Whole numbers make many ties.
    fn vector() -> impl Strategy<Value = DVec3> {
        let tied = prop::array::uniform3(-3..4).prop_map(|v| v.map(f64::from));
        prop_oneof![tied, prop::array::uniform3(-3.0..3.0)].prop_map(DVec3::from_array)
    }

    proptest! {
        /// The slow twin: all points.
        #[test]
        fn finds_the_first_of_the_nearest_that_fit(
            positions in prop::collection::vec(vector(), 0..200), to in vector(), reach in 0..8, every in 1_usize..4,
        ) {
            let up = |up: bool| if up { DVec3::Z } else { DVec3::NEG_Z };
            let point = |(i, &position): (usize, &DVec3)| SurfacePoint { position, normal: up(i % every == 0) };
            let points: Vec<SurfacePoint> = positions.iter().enumerate().map(point).collect();
            let fits = |point: &SurfacePoint| point.normal.z > 0.0;
            let dist_sq = |point: &SurfacePoint| point.position.distance_squared(to);
            let within = points.iter().filter(|point| fits(point) && dist_sq(point) <= (reach * reach) as f64);
            let expected = within.min_by(|a, b| dist_sq(a).total_cmp(&dist_sq(b)));
            let tree = PointTree::new(&points, &Cancel::default()).unwrap();
            let found = tree.nearest(to, reach as f64, fits);
            prop_assert_eq!(found, expected);
            let number = |found: &SurfacePoint| tree.nodes.iter().find(|node| std::ptr::eq(&node.point, found)).unwrap().number;
            let first = points.iter().position(|point| fits(point) && expected.is_some_and(|e| dist_sq(e) == dist_sq(point)));
            prop_assert_eq!(found.map(number), first);
        }
    }
}
