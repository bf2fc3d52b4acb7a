//! A scan from the first view to the last, measured at every step.

use crate::SimError;
use crate::scene::Scene;
use crate::surface::SurfaceCoverage;
use crate::truth::{ObjectVoxels, VoxelScore};
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::geometry::Pose;
use nextview::motion::Way;
use nextview::sensor::Frame;
use nextview::session::{Decision, NextView, Session, StepReport, StopReason};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Everything about one step of a scan, with what is measured of it: the truth, in a simulation.
#[derive(Clone, Debug)]
pub struct Step<M = Measures> {
    /// What the session tells.
    pub report: StepReport,
    /// What the camera told, with the pose in which the session mapped it.
    pub frame: Frame,
    /// How that compares with the truth.
    pub measures: M,
    /// Length of the straight path through all views so far, metres.
    pub path_length: f64,
    /// The way from the view before, as a robot would go.
    pub way: Way,
    /// Time to decide on this view.
    pub plan_time: Duration,
    /// Time to write its frame into the map.
    pub map_time: Duration,
    /// Time to take its frame: to render it, in a simulation.
    pub capture_time: Duration,
}

/// What was scanned so far, compared with the true object.
#[derive(Clone, Copy, Debug)]
pub struct Measures {
    /// The map in the finest voxels against the object voxels, in the block of those: object voxels outside the
    /// session's box do not count as covered, and what is occupied outside the block is not counted at all.
    pub voxels: VoxelScore,
    /// Number of object voxels truly seen so far: those with a point of the true surface that a pixel measured, wherever
    /// noise and a wrong pose put that point in the map. All other measures are of what the frames claim.
    pub n_seen: usize,
    /// Share, 0..=1, of the true surface with a measured point of the object within 1, 2 and 5 mm.
    pub surface_coverage: [f64; 3],
    /// How far the points of the object are from where they are, for the pose in which the frame was mapped: root mean square
    /// over those that a pixel measured, metres; 0 if there are none. The error of the depth is not in it. None where the
    /// true poses are not known.
    pub misplacement: Option<f64>,
}

impl<M> Step<M> {
    /// The same step with other measures.
    pub fn map<N>(self, change: impl FnOnce(M) -> N) -> Step<N> {
        let Self { report, frame, measures, path_length, way, plan_time, map_time, capture_time } = self;
        Step {
            measures: change(measures),
            report,
            frame,
            path_length,
            way,
            plan_time,
            map_time,
            capture_time,
        }
    }
}

/// Runs a session in a simulation until it stops; every step is handed out as soon as it is done, and may end the run.
pub fn run(
    session: &mut Session,
    scene: &Scene,
    object: &ObjectVoxels,
    on_step: impl FnMut(Step) -> ControlFlow<StopReason>,
) -> Result<StopReason, SimError> {
    let mut surface = SurfaceCoverage::new(scene.camera().mesh());
    let mut seen = FixedBitSet::with_capacity(object.len());
    let mut is_first = true;
    let capture = |next: &NextView| {
        let capture = scene.camera().capture_with_truth(&next.world_from_camera)?;
        let claims_right_pose = is_first && scene.camera().noise().first_pose_is_right;
        is_first = false;
        let frame = match claims_right_pose {
            true => capture.frame.with_pose(next.world_from_camera),
            false => capture.frame,
        };
        Ok((frame, (capture.truth, capture.of_object)))
    };
    let measure = |session: &Session, frame: &Frame, (truth, of_object): (Frame, Frame)| {
        let mapped_from = frame.world_from_camera();
        seen.union_with(&object.seen_in(&truth));
        surface.add(&of_object.with_pose(mapped_from));
        Measures {
            voxels: object.compare(&session.map().snapshot(object.block())),
            n_seen: seen.count_ones(..),
            surface_coverage: surface.shares(),
            misplacement: Some(misplacement(&truth, &mapped_from)),
        }
    };
    run_with(session, capture, measure, on_step)
}

/// The same wherever the frames come from: `capture` takes the frame of a view, with whatever `measure` needs besides that
/// frame, in the pose in which it was mapped, to say how the session stands after it.
pub fn run_with<T, M, E>(
    session: &mut Session,
    mut capture: impl FnMut(&NextView) -> Result<(Frame, T), E>,
    mut measure: impl FnMut(&Session, &Frame, T) -> M,
    mut on_step: impl FnMut(Step<M>) -> ControlFlow<StopReason>,
) -> Result<StopReason, E> {
    let mut path = Path::default();
    loop {
        let (decision, plan_time) = timed(|| session.decide());
        let next = match decision {
            Decision::Move(next) => next,
            Decision::Stop(reason) => return Ok(reason),
        };
        let way = session.way_to(&next.world_from_camera);
        let (taken, capture_time) = timed(|| capture(&next));
        let (frame, known) = taken?;
        let (report, map_time) = timed(|| session.observe(&frame));
        let frame = frame.with_pose(report.world_from_camera); // registration may correct the pose that the camera claims
        let goes_on = on_step(Step {
            report,
            measures: measure(session, &frame, known),
            path_length: path.extend_to(next.world_from_camera.translation()),
            way,
            plan_time,
            map_time,
            capture_time,
            frame,
        });
        if let ControlFlow::Break(reason) = goes_on {
            return Ok(reason);
        }
    }
}

/// Root mean square distance between the points of a frame in its own pose and in another, metres.
fn misplacement(truth: &Frame, mapped_from: &Pose) -> f64 {
    let motion = *mapped_from * truth.world_from_camera().inverse();
    let (mut n, mut sum) = (0, 0.0);
    for point in (0..truth.image().height()).flat_map(|v| truth.row_ray_ends(v)).filter(|(_, hit)| *hit) {
        (n, sum) = (n + 1, sum + motion.transform_point(point.0).distance_squared(point.0));
    }
    if n > 0 { (sum / n as f64).sqrt() } else { 0.0 }
}

/// The length of a path that grows.
#[derive(Default)]
struct Path {
    length: f64,
    end: Option<DVec3>,
}

impl Path {
    fn extend_to(&mut self, position: DVec3) -> f64 {
        self.length += self.end.map_or(0.0, |end| end.distance(position));
        self.end = Some(position);
        self.length
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let value = work();
    (value, start.elapsed())
}
