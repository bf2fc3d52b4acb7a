mod cloud;
mod grid;

use super::{Choice, Plan, Situation, ViewPlanner};
use crate::{Cancelled, Error};
use cloud::{DensityCloud, PointClass};
use glam::DVec3;
use rayon::prelude::*;

/// Looks straight at the edges of densely measured surface: the surface edge explorer of Border & Gammell
/// (SEE, International Journal of Robotics Research 2024).
///
/// It needs the frames and uses no voxels. A point with many others around it is a core point, and one
/// between core and sparse points a frontier point. Each frontier point proposes the view along its normal.
/// The next view is a proposal near the camera that sees many frontier points, among them that of the nearest
/// proposal. There is no choice once there are no frontier points, or no view sees one.
///
/// Views are candidates: a proposal becomes the open one of smallest angle to the normal that sees the point.
/// A point is given up after three views of it. The publication instead moves its view, then looks from where
/// the point was first seen. Where the text leaves something open, the authors' code decides.
#[derive(Clone, Debug, Default)]
pub struct See {
    /// The frontier points of all choices so far, in world coordinates.
    targets: Vec<DVec3>,
}

/// Radius in which density is measured (the paper's r), voxels.
const RADIUS: f64 = 3.0;

/// Least distance between points (the paper's epsilon), voxels.
const GAP: f64 = 0.5;

/// Step of the search for occluding points (the paper's upsilon), voxels: about the same share of the radius
/// as in the authors' configuration, 1 cm of 1.7.
const STEP: f64 = 1.8;

/// Maximum number of proposals, those nearest to the camera (the paper's tau).
const N_PROPOSALS: usize = 100;

/// Largest angle between the normal of a point and a view of it, as its cosine: 60 degrees.
const LEAST_COSINE: f64 = 0.5;

/// Number of views of a point after which it is given up.
const MOST_VIEWS: usize = 3;

/// Added to the distance of a view, metres, so that none is infinitely near.
const LEAST_DISTANCE: f64 = 0.001;

impl ViewPlanner for See {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let Some(camera) = situation.camera_position() else { return Ok(Plan::default()) };
        let scene = EdgeScene::new(situation)?;
        let edges = scene.edges(&self.targets, camera)?;
        let proposals = scene.proposals(&edges)?;
        let choice = scene.choose(&edges, &proposals, camera);
        self.targets.extend(choice.as_ref().map(|(_, target)| *target + scene.origin));
        Ok(Plan { choice: choice.map(|(choice, _)| choice), ..Plan::default() })
    }
}

/// A frontier point and its normal.
#[derive(Clone, Copy, Debug)]
struct Edge {
    point: DVec3,
    normal: DVec3,
}

/// A view of an edge, and the edges that it sees.
struct Proposal {
    edge: usize,
    view: usize,
    sees: Vec<bool>,
}

struct EdgeScene<'a> {
    situation: &'a Situation<'a>,
    cloud: DensityCloud,
    /// The origin of the points in the world.
    origin: DVec3,
    /// Metres.
    voxel_size: f64,
    open: Vec<usize>,
}

impl<'a> EdgeScene<'a> {
    fn new(situation: &'a Situation<'a>) -> Result<Self, Cancelled> {
        let (lattice, block) = (situation.snapshot().lattice(), situation.snapshot().block());
        let (voxel_size, bounds) = (lattice.voxel_size(), lattice.bounds(&block));
        let (gap, radius) = (GAP * voxel_size, RADIUS * voxel_size);
        let cloud = DensityCloud::new(situation.frames(), bounds, gap, radius, situation.cancel())?;
        Ok(Self { situation, cloud, origin: bounds.min, voxel_size, open: situation.open_views() })
    }

    /// Position of the camera in a view, in the coordinates of the points.
    fn place(&self, view: usize) -> DVec3 {
        self.situation.views().pose(view).translation() - self.origin
    }

    /// The frontier points that were not given up, nearest own view to the camera first.
    fn edges(&self, targets: &[DVec3], camera: DVec3) -> Result<Vec<Edge>, Cancelled> {
        let camera = camera - self.origin;
        let middle = 0.5 * self.situation.snapshot().block().dims().as_dvec3() * self.voxel_size;
        let from_middle = self.open.iter().map(|&view| self.place(view).distance(middle));
        let distance = from_middle.sum::<f64>() / self.open.len().max(1) as f64;
        let radius = RADIUS * self.voxel_size;
        let is_near = |point: DVec3| move |target: &&DVec3| (**target).distance(point) <= radius;
        let is_given_up =
            |point: DVec3| targets.iter().filter(is_near(point + self.origin)).count() >= MOST_VIEWS;
        let classes = self.cloud.classes(self.situation.cancel())?;
        let frontier = (0..classes.len()).filter(|&number| classes[number] == PointClass::Frontier);
        let edge = |number: usize| {
            let point = self.cloud.points[number];
            let normal = (!is_given_up(point)).then(|| self.cloud.normal(number))??;
            Some((Edge { point, normal }, (point + normal * distance).distance(camera)))
        };
        let mut edges: Vec<(Edge, f64)> = frontier.filter_map(edge).collect();
        edges.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(edges.into_iter().map(|(edge, _)| edge).take(N_PROPOSALS).collect())
    }

    /// A view of each edge that has one.
    fn proposals(&self, edges: &[Edge]) -> Result<Vec<Proposal>, Cancelled> {
        let propose = |number: usize| {
            self.situation.cancel().check()?;
            let cosine = |view: usize| edges[number].cosine(self.place(view));
            let mut views: Vec<(usize, f64)> = self.open.iter().map(|&view| (view, cosine(view))).collect();
            views.sort_by(|a, b| b.1.total_cmp(&a.1));
            let view = views.into_iter().map(|(view, _)| view).find(|&view| self.sees(view, &edges[number]));
            let sees = |view: usize| edges.iter().map(|edge| self.sees(view, edge)).collect();
            Ok(view.map(|view| Proposal { edge: number, view, sees: sees(view) }))
        };
        let proposals: Result<Vec<Option<Proposal>>, Cancelled> =
            (0..edges.len()).into_par_iter().map(propose).collect();
        Ok(proposals?.into_iter().flatten().collect())
    }

    /// Whether a view shows a frontier point: in its image and range, not too flat, and not occluded.
    fn sees(&self, view: usize, edge: &Edge) -> bool {
        let (camera, range) = (self.place(view), self.situation.depth_range());
        let camera_from_world = self.situation.views().pose(view).inverse();
        let in_camera = camera_from_world.transform_point(edge.point + self.origin);
        let intrinsics = self.situation.intrinsics();
        edge.cosine(camera) >= LEAST_COSINE
            && (range.min..=range.max).contains(&in_camera.z)
            && intrinsics.project(in_camera).is_some_and(|pixel| intrinsics.contains(pixel))
            && self.cloud.is_visible(edge.point, edge.normal, camera, STEP * self.voxel_size)
    }

    /// The next view and its frontier point. The base is the proposal nearest to the camera. Among the
    /// proposals that see the frontier point of the base, and more points than the base does, the one with
    /// the most points per distance is chosen; if there is none, the base.
    fn choose(&self, edges: &[Edge], proposals: &[Proposal], camera: DVec3) -> Option<(Choice, DVec3)> {
        let distance = |proposal: &&Proposal| self.place(proposal.view).distance(camera - self.origin);
        let base = proposals.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let n_seen = |proposal: &Proposal| proposal.sees.iter().filter(|&&is_seen| is_seen).count();
        let score = |proposal: &Proposal| n_seen(proposal) as f64 / (distance(&proposal) + LEAST_DISTANCE);
        let is_better = |proposal: &&Proposal| proposal.sees[base.edge] && n_seen(proposal) > n_seen(base);
        let better = proposals.iter().filter(is_better);
        let best = better.reduce(|best, other| if score(other) > score(best) { other } else { best });
        let next = best.unwrap_or(base);
        let explanation =
            [("proposals", proposals.len() as f64), ("seen_frontier_points", n_seen(next) as f64)];
        let choice = Choice { explanation: Some(explanation.into()), ..Choice::new(next.view, score(next)) };
        Some((choice, edges[next.edge].point))
    }
}

impl Edge {
    /// Cosine of the angle between the normal and the direction to a camera.
    fn cosine(&self, camera: DVec3) -> f64 {
        self.normal.dot((camera - self.point).normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cancel;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::Snapshot;
    use crate::sensor::{Frame, Intrinsics};
    use crate::view::{ViewSpace, generate};
    use cloud::tests::frames;
    use glam::{DMat3, IVec3, UVec3};

    /// Voxels of 7 mm: points of the images are a little denser than the gap.
    fn unknown() -> Snapshot {
        let block = VoxelBlock::new(IVec3::splat(-12), UVec3::splat(24)).unwrap();
        Snapshot::from_fn(Lattice::new(0.007).unwrap(), block, |_| None)
    }

    fn views() -> ViewSpace {
        generate::fibonacci_sphere(DVec3::ZERO, 0.4, 80).unwrap()
    }

    fn with_situation<T>(frames: &[Frame], visited: &[usize], use_it: impl FnOnce(&Situation<'_>) -> T) -> T {
        let (snapshot, views, camera, cancel) = (unknown(), views(), Intrinsics::d435i(), Cancel::default());
        let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_frames(frames);
        use_it(&situation.with_visited(visited).unwrap())
    }

    fn plan(see: &mut See, frames: &[Frame], visited: &[usize]) -> Option<Choice> {
        with_situation(frames, visited, |situation| see.plan(situation).unwrap().choice)
    }

    /// Points of all frames relative to the lowest corner of the box, none at most `gap` from an earlier one,
    /// and the place of the camera of each.
    fn thinned(frames: &[Frame], origin: DVec3, gap: f64) -> Vec<(DVec3, DVec3)> {
        let mut kept: Vec<(DVec3, DVec3)> = Vec::new();
        for frame in frames {
            let camera = frame.world_from_camera().translation() - origin;
            for point in frame.points().map(|point| point - origin) {
                if kept.iter().all(|(other, _)| other.distance(point) > gap) {
                    kept.push((point, camera));
                }
            }
        }
        kept
    }

    /// The direction of least spread. A matrix whose largest eigenvalue has that direction is multiplied by
    /// itself until only that direction is left.
    fn least_spread(points: &[DVec3]) -> DVec3 {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let spread = points.iter().fold(DMat3::ZERO, |sum, &point| {
            let d = point - mean;
            sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
        });
        let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        let mut power = DMat3::from_diagonal(DVec3::splat(trace)) - spread;
        for _ in 0..60 {
            let largest = power.to_cols_array().iter().fold(0.0_f64, |most, number| most.max(number.abs()));
            power *= 1.0 / largest;
            power = power * power;
        }
        let columns = [power.x_axis, power.y_axis, power.z_axis];
        columns.into_iter().max_by(|a, b| a.length().total_cmp(&b.length())).unwrap().normalize()
    }

    /// Points between dense and sparse ones, each with its normal.
    fn frontier(points: &[(DVec3, DVec3)], radius: f64) -> Vec<(DVec3, DVec3)> {
        let around = |at: usize| -> Vec<usize> {
            (0..points.len()).filter(|&other| points[other].0.distance(points[at].0) <= radius).collect()
        };
        let around: Vec<Vec<usize>> = (0..points.len()).map(around).collect();
        let mut counts: Vec<usize> = around.iter().map(Vec::len).collect();
        counts.sort_unstable();
        let median = counts[counts.len() / 2] as f64;
        let is_core = |at: usize| around[at].len() >= 3 && around[at].len() as f64 >= 2.0 / 3.0 * median;
        let mut edges = Vec::new();
        for at in (0..points.len()).filter(|&at| !is_core(at)) {
            let has_core = around[at].iter().any(|&other| is_core(other));
            let has_sparse = around[at].iter().any(|&other| other != at && !is_core(other));
            if !has_core || !has_sparse || around[at].len() < 3 {
                continue;
            }
            let near: Vec<DVec3> = around[at].iter().map(|&other| points[other].0).collect();
            let toward: DVec3 = around[at].iter().map(|&other| points[other].1 - points[other].0).sum();
            let normal = least_spread(&near);
            edges.push((points[at].0, if normal.dot(toward) < 0.0 { -normal } else { normal }));
        }
        edges
    }

    /// Whether the line of sight from a point, off the surface first, to a camera is free of points.
    fn is_open(points: &[(DVec3, DVec3)], (point, normal): (DVec3, DVec3), camera: DVec3, step: f64) -> bool {
        let is_clear = |place: DVec3| points.iter().all(|(other, _)| other.distance(place) > step);
        let mut n = 2;
        while !is_clear(point + normal * (step * n as f64)) {
            n += 1;
        }
        let (distance, mut is_open) = (point.distance(camera), true);
        while is_open && step * (n as f64) < distance {
            is_open = is_clear(point + (camera - point) * (step * n as f64 / distance));
            n += 1;
        }
        is_open
    }

    /// The slow twin: every rule of the publication as a loop over all points and views.
    fn by_definition(situation: &Situation<'_>) -> (usize, f64) {
        let (h, origin) = (0.007, DVec3::splat(-0.084));
        let points = thinned(situation.frames(), origin, 0.5 * h);
        let camera = situation.camera_position().unwrap();
        let place = |view: usize| situation.views().pose(view).translation();
        let edges = frontier(&points, 3.0 * h).into_iter();
        let mut edges: Vec<(DVec3, DVec3)> = edges.map(|(point, normal)| (point + origin, normal)).collect();
        let ideal = |(point, normal): &(DVec3, DVec3)| (*point + *normal * 0.4).distance(camera);
        edges.sort_by(|a, b| ideal(a).total_cmp(&ideal(b)));
        edges.truncate(100);
        let cosine = |view: usize, edge: usize| {
            let way = place(view) - edges[edge].0;
            edges[edge].1.dot(way) / way.length()
        };
        let shows = |view: usize, edge: usize| {
            let (point, normal) = edges[edge];
            let in_camera = situation.views().pose(view).inverse().transform_point(point);
            let pixel = situation.intrinsics().project(in_camera);
            let range = situation.depth_range();
            pixel.is_some_and(|pixel| situation.intrinsics().contains(pixel))
                && (range.min..=range.max).contains(&in_camera.z)
                && cosine(view, edge) >= 0.5
                && is_open(&points, (point - origin, normal), place(view) - origin, 1.8 * h)
        };
        let views = 0..situation.views().len();
        let seen: Vec<Vec<bool>> =
            views.map(|view| (0..edges.len()).map(|edge| shows(view, edge)).collect()).collect();
        let sees = |view: usize, edge: usize| seen[view][edge];
        let open = situation.open_views();
        let mut proposals = Vec::new();
        for edge in 0..edges.len() {
            let mut best: Option<usize> = None;
            for &view in open.iter().filter(|&&view| sees(view, edge)) {
                if best.is_none_or(|best| cosine(view, edge) > cosine(best, edge)) {
                    best = Some(view);
                }
            }
            proposals.extend(best.map(|view| (edge, view)));
        }
        let out = |view: usize| (0..edges.len()).filter(|&edge| sees(view, edge)).count();
        let distance = |view: usize| place(view).distance(camera);
        let mut base = proposals[0];
        for &other in &proposals {
            if distance(other.1) < distance(base.1) {
                base = other;
            }
        }
        let score = |view: usize| out(view) as f64 / (distance(view) + 0.001);
        let mut next: Option<usize> = None;
        for &(_, view) in &proposals {
            let is_better = sees(view, base.0) && out(view) > out(base.1);
            if is_better && next.is_none_or(|next| score(view) > score(next)) {
                next = Some(view);
            }
        }
        let next = next.unwrap_or(base.1);
        (next, score(next))
    }

    #[test]
    fn the_choice_is_that_of_the_definition() {
        for seen in [&[DVec3::X][..], &[DVec3::X, DVec3::Y], &[DVec3::new(1.0, 1.0, 1.0)]] {
            let frames = frames(seen);
            for visited in [&[3][..], &[40, 12]] {
                let (view, score) = with_situation(&frames, visited, by_definition);
                let choice = plan(&mut See::default(), &frames, visited).unwrap();
                assert_eq!(choice.view, view);
                assert!((choice.score - score).abs() < 1e-9 * score);
            }
        }
    }

    #[test]
    fn it_moves_on_past_the_edge_and_gives_points_up() {
        let frames = frames(&[DVec3::X]);
        let mut see = See::default();
        let mut visited = vec![0];
        while let Some(choice) = plan(&mut see, &frames, &visited) {
            visited.push(choice.view);
        }
        assert!((4..80).contains(&visited.len()), "{visited:?}");
        let counted = |target: &DVec3| {
            let n_before = see.targets.iter().filter(|other| other.distance(*target) <= 3.0 * 0.007).count();
            assert!(n_before > 0);
            n_before
        };
        assert!(
            see.targets.iter().map(counted).max() >= Some(MOST_VIEWS),
            "looked again at what stayed an edge"
        );
    }

    #[test]
    fn without_frames_there_is_no_edge() {
        assert_eq!(plan(&mut See::default(), &[], &[3]), None);
        let all: Vec<usize> = (0..80).collect();
        assert_eq!(plan(&mut See::default(), &frames(&[DVec3::X]), &all), None);
    }

    #[test]
    fn threads_do_not_show() {
        let frames = frames(&[DVec3::X, DVec3::Z]);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| plan(&mut See::default(), &frames, &[5]))
        };
        assert_eq!(run(1), run(4));
    }
}
