//! A simulated scan from the first view to the last, measured at every step.

use crate::SimError;
use crate::scene::Scene;
use crate::surface::SurfaceCoverage;
use crate::truth::{ObjectVoxels, VoxelScore};
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::geometry::Pose;
use nextview::sensor::Frame;
use nextview::session::{Decision, Session, StepReport, StopReason};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Everything measured at one step of a simulated scan.
#[derive(Clone, Debug)]
pub struct Step {
    /// What the session tells.
    pub report: StepReport,
    /// What the camera told, with the pose in which the session mapped it.
    pub frame: Frame,
    /// The map in the finest voxels against the object voxels, in the block of those: object voxels outside the
    /// session's box do not count as covered, and what is occupied outside the block is not counted at all.
    pub voxels: VoxelScore,
    /// Number of object voxels truly seen so far: those with a point of the true surface that a pixel measured, wherever
    /// noise and a wrong pose put that point in the map. All other measures are of what the frames claim.
    pub n_seen: usize,
    /// Share, 0..=1, of the true surface with a measured point of the object within 1, 2 and 5 mm.
    pub surface_coverage: [f64; 3],
    /// How far the points of the object are from where they are, for the pose in which the frame was mapped: root mean square
    /// over those that a pixel measured, metres; 0 if there are none. The error of the depth is not in it.
    pub misplacement: f64,
    /// Length of the straight path through all views so far, metres.
    pub path_length: f64,
    /// Time to decide on this view.
    pub plan_time: Duration,
    /// Time to write its frame into the map.
    pub map_time: Duration,
    /// Time to render its depth image.
    pub render_time: Duration,
}

/// Runs a session until it stops; every step is handed out as soon as it is done, and may end the run.
pub fn run(
    session: &mut Session,
    scene: &Scene,
    object: &ObjectVoxels,
    mut on_step: impl FnMut(Step) -> ControlFlow<StopReason>,
) -> Result<StopReason, SimError> {
    let mut surface = SurfaceCoverage::new(scene.camera().mesh());
    let mut seen = FixedBitSet::with_capacity(object.len());
    let mut path = Path::default();
    loop {
        let (decision, plan_time) = timed(|| session.decide());
        let next = match decision {
            Decision::Move(next) => next,
            Decision::Stop(reason) => return Ok(reason),
        };
        let (capture, render_time) = timed(|| scene.camera().capture_with_truth(&next.world_from_camera));
        let capture = capture?;
        let claims_right_pose = scene.camera().noise().first_pose_is_right && path.end.is_none();
        let frame = match claims_right_pose {
            true => capture.frame.with_pose(next.world_from_camera),
            false => capture.frame,
        };
        let (report, map_time) = timed(|| session.observe(&frame));
        seen.union_with(&object.seen_in(&capture.truth));
        let mapped_from = report.world_from_camera; // registration may correct the pose that the camera claims
        surface.add(&capture.of_object.with_pose(mapped_from));
        let goes_on = on_step(Step {
            report,
            voxels: object.compare(&session.map().snapshot(object.block())),
            n_seen: seen.count_ones(..),
            misplacement: misplacement(&capture.truth, &mapped_from),
            surface_coverage: [0.001, 0.002, 0.005].map(|distance| surface.share_within(distance)),
            path_length: path.extend_to(next.world_from_camera.translation()),
            plan_time,
            map_time,
            render_time,
            frame: frame.with_pose(mapped_from),
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
