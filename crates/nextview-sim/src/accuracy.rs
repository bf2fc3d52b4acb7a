//! Accuracy of the measurement of the true surface.

use crate::mesh::TriangleMesh;
use glam::DVec3;
use nextview::geometry::Aabb;

/// Distances of points from the true surface, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Mean distance.
    pub mean: f64,
    /// Median distance: half of the points are nearer.
    pub median: f64,
    /// 95 % quantile: 95 % of the points are nearer.
    pub p95: f64,
}

impl Accuracy {
    /// Evaluates these distances; `None` if there are none.
    pub fn of(distances: &[f64]) -> Option<Self> {
        let mut sorted = distances.to_vec();
        sorted.sort_by(f64::total_cmp);
        let quantile = |q: f64| sorted.get((q * (sorted.len() as f64 - 1.0)).round() as usize).copied();
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        Some(Self { mean, median: quantile(0.5)?, p95: quantile(0.95)? })
    }
}

/// Distances of points from a surface, or from a cloud of points: a tree of boxes around the triangles.
#[derive(Clone, Debug)]
pub struct SurfaceDistance {
    /// The corners of the triangles in the order of the tree.
    triangles: Vec<[DVec3; 3]>,
    root: TriangleNode,
}

#[derive(Clone, Debug)]
struct TriangleNode {
    bounds: Aabb,
    content: NodeContent,
}

/// The nearest triangle so far, by its number in the tree.
#[derive(Clone, Copy, Debug)]
struct NearestTriangle {
    dist_sq: f64,
    triangle: usize,
}

#[derive(Clone, Debug)]
enum NodeContent {
    /// From one triangle up to another.
    Leaf {
        start: usize,
        end: usize,
    },
    Halves(Box<[TriangleNode; 2]>),
}

/// A box of fewer triangles is not divided further.
const LEAF: usize = 8;

impl SurfaceDistance {
    /// Builds the tree of a mesh.
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self::of((0..mesh.triangles().len()).map(|i| mesh.corners(i)).collect())
    }

    /// Builds the tree of a cloud of finite points, as triangles without size; `None` if there are none.
    pub fn to_points(points: &[DVec3]) -> Option<Self> {
        (!points.is_empty()).then(|| Self::of(points.iter().map(|&point| [point; 3]).collect()))
    }

    fn of(mut triangles: Vec<[DVec3; 3]>) -> Self {
        let root = TriangleNode::new(&mut triangles, 0);
        Self { triangles, root }
    }

    /// Returns the box around the surface.
    pub fn bounds(&self) -> Aabb {
        self.root.bounds
    }

    /// Returns the distance of a finite point from the surface, metres.
    pub fn at(&self, point: DVec3) -> f64 {
        self.nearest(point, f64::INFINITY).dist_sq.sqrt()
    }

    /// Returns the signed distance: negative inside, if the triangles' corners run counter-clockwise seen
    /// from outside. Where triangles meet, the sum of their normals decides (Bærentzen & Aanæs 2005, without
    /// their angles).
    pub fn signed_at(&self, point: DVec3) -> f64 {
        let foot = self.foot(point).0;
        let distance = foot.distance(point);
        let mut normal = DVec3::ZERO;
        self.add_normals(&self.root, point, distance * distance * (1.0 + 1e-9) + f64::EPSILON, &mut normal);
        if (point - foot).dot(normal) < 0.0 { -distance } else { distance }
    }

    /// Adds the normals of the triangles at this distance.
    fn add_normals(&self, node: &TriangleNode, point: DVec3, dist_sq: f64, normal: &mut DVec3) {
        match &node.content {
            NodeContent::Leaf { start, end } => {
                for [a, b, c] in &self.triangles[*start..*end] {
                    if nearest_point([*a, *b, *c], point).distance_squared(point) <= dist_sq {
                        *normal += (b - a).cross(c - a).normalize_or_zero();
                    }
                }
            }
            NodeContent::Halves(halves) => {
                for half in halves.iter().filter(|half| half.distance_sq(point) <= dist_sq) {
                    self.add_normals(half, point, dist_sq, normal);
                }
            }
        }
    }

    /// Returns the surface point nearest to a finite point, and the normal of its triangle, which is zero for
    /// a triangle without size.
    pub fn foot(&self, point: DVec3) -> (DVec3, DVec3) {
        self.foot_on(self.nearest(point, f64::INFINITY).triangle, point)
    }

    /// As [`foot`](Self::foot), but `None` if the point is farther away than `reach` metres, which takes much
    /// less time to find out.
    pub(crate) fn foot_within(&self, point: DVec3, reach: f64) -> Option<(DVec3, DVec3)> {
        let limit = reach * reach;
        // The search excludes the limit itself.
        let nearest = self.nearest(point, limit.next_up());
        (nearest.dist_sq <= limit).then(|| self.foot_on(nearest.triangle, point))
    }

    fn foot_on(&self, triangle: usize, point: DVec3) -> (DVec3, DVec3) {
        let triangle = self.triangles[triangle];
        let [a, b, c] = triangle;
        (nearest_point(triangle, point), (b - a).cross(c - a).normalize_or_zero())
    }

    /// The nearest triangle if its squared distance is below the limit; otherwise the limit and any triangle.
    fn nearest(&self, point: DVec3, limit: f64) -> NearestTriangle {
        let mut nearest = NearestTriangle { dist_sq: limit, triangle: 0 };
        self.search(&self.root, point, &mut nearest);
        nearest
    }

    fn search(&self, node: &TriangleNode, point: DVec3, nearest: &mut NearestTriangle) {
        match &node.content {
            NodeContent::Leaf { start, end } => {
                for (triangle, corners) in (*start..*end).zip(&self.triangles[*start..*end]) {
                    let dist_sq = nearest_point(*corners, point).distance_squared(point);
                    if dist_sq < nearest.dist_sq {
                        *nearest = NearestTriangle { dist_sq, triangle };
                    }
                }
            }
            NodeContent::Halves(halves) => {
                let [a, b] = halves.each_ref().map(|half| (half, half.distance_sq(point)));
                for (half, dist_sq) in if a.1 <= b.1 { [a, b] } else { [b, a] } {
                    if dist_sq < nearest.dist_sq {
                        self.search(half, point, nearest);
                    }
                }
            }
        }
    }
}

impl TriangleNode {
    /// Divides the triangles (at least one, the first with the number `start`) at the middle one along the
    /// longest side of their box.
    fn new(triangles: &mut [[DVec3; 3]], start: usize) -> Self {
        let bounds = Aabb::around(triangles.iter().copied().flatten()).expect("there are triangles");
        let n = triangles.len();
        if n < LEAF {
            return Self { bounds, content: NodeContent::Leaf { start, end: start + n } };
        }
        let axis = bounds.size().max_position();
        let along = |t: &[DVec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
        triangles.select_nth_unstable_by(n / 2, |a, b| along(a).total_cmp(&along(b)));
        let (low, high) = triangles.split_at_mut(n / 2);
        let halves = [Self::new(low, start), Self::new(high, start + n / 2)];
        Self { bounds, content: NodeContent::Halves(Box::new(halves)) }
    }

    fn distance_sq(&self, point: DVec3) -> f64 {
        point.clamp(self.bounds.min, self.bounds.max).distance_squared(point)
    }
}

/// The point of a triangle nearest to another point: that of its plane if it lies inside, or else of the
/// nearest edge. The triangle may be without size.
fn nearest_point([a, b, c]: [DVec3; 3], point: DVec3) -> DVec3 {
    let normal = (b - a).cross(c - a);
    if a == b && b == c {
        return a;
    }
    let is_inside = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) >= 0.0;
    if is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return point - normal * ((point - a).dot(normal) / normal.length_squared());
    }
    let on_edges = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        let edge = to - from;
        let share = (point - from).dot(edge) / edge.length_squared();
        from + edge * share.clamp(0.0, 1.0)
    });
    let distance = |p: &DVec3| p.distance_squared(point);
    on_edges.into_iter().reduce(|p, q| if distance(&q) < distance(&p) { q } else { p }).unwrap_or(a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use nextview::geometry::random::Random;
    use proptest::prelude::*;

    #[test]
    fn the_tree_finds_what_asking_every_triangle_finds() {
        let mesh = builtin::by_name("bracket").unwrap();
        let distance = SurfaceDistance::new(&mesh);
        let mut random = Random::new(1, 0);
        for _ in 0..300 {
            let point = random.in_cube() * 0.2;
            let of_triangle = |i| nearest_point(mesh.corners(i), point).distance(point);
            let expected = (0..mesh.triangles().len()).map(of_triangle).fold(f64::INFINITY, f64::min);
            assert!((distance.at(point) - expected).abs() < 1e-12, "{point}");
            let (foot, normal) = distance.foot(point);
            assert!((foot.distance(point) - expected).abs() < 1e-12 && normal.is_normalized(), "{point}");
            assert_eq!(distance.foot_within(point, 1.01 * expected), Some((foot, normal)), "{point}");
            assert_eq!(distance.foot_within(point, 0.99 * expected), None, "{point}");
        }
    }

    proptest! {
        /// No point of a fine net over the triangle is nearer, and one is hardly farther.
        #[test]
        fn the_nearest_point_is_nearest(corners in prop::array::uniform9(-1.0..1.0), p in prop::array::uniform3(-2.0..2.0)) {
            let [a, b, c] = [0, 3, 6].map(|i| DVec3::new(corners[i], corners[i + 1], corners[i + 2]));
            prop_assume!((b - a).cross(c - a).length() > 1e-3);
            let point = DVec3::from_array(p);
            let found = nearest_point([a, b, c], point).distance(point);
            let net = (0..=60).flat_map(|i| (0..=60 - i).map(move |j| (i as f64 / 60.0, j as f64 / 60.0)));
            let nearest = net.map(|(u, v)| (a + (b - a) * u + (c - a) * v).distance(point)).fold(9.0, f64::min);
            prop_assert!(found <= nearest + 1e-12 && nearest <= found + 0.06, "{found} {nearest}");
        }
    }

    #[test]
    fn inside_is_negative_also_beside_edges_and_corners() {
        let side = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 2.0 - 1.0;
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let cube = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
        let distance = SurfaceDistance::new(&cube);
        let mut random = Random::new(6, 0);
        for _ in 0..500 {
            let point = 2.0 * random.in_cube();
            let beyond = point.abs().max_element() - 1.0;
            assert_eq!(side(distance.signed_at(point)), side(beyond), "{point}");
            assert_eq!(distance.signed_at(point).abs(), distance.at(point));
        }
    }

    #[test]
    fn a_cloud_is_as_far_as_its_nearest_point() {
        let mut random = Random::new(2, 0);
        let mut points: Vec<DVec3> = (0..300).map(|_| random.in_cube()).collect();
        points.extend([points[0]; 20]); // equal ones are no trouble
        let distance = SurfaceDistance::to_points(&points).unwrap();
        for _ in 0..200 {
            let from = random.in_cube() * 1.5;
            let expected = points.iter().map(|point| point.distance(from)).fold(f64::INFINITY, f64::min);
            assert_eq!(distance.at(from), expected);
        }
        assert!(SurfaceDistance::to_points(&[]).is_none());
    }

    #[test]
    fn accuracy_is_mean_median_and_95_percent() {
        let distances: Vec<f64> = (0..=100).rev().map(|mm| mm as f64).collect();
        assert_eq!(Accuracy::of(&distances), Some(Accuracy { mean: 50.0, median: 50.0, p95: 95.0 }));
        assert_eq!(Accuracy::of(&[]), None);
    }
}
