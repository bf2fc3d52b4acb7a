//! A scan from the first view to the last, measured at every step.

use crate::SimError;
use crate::gauge::{Gauge, Measures, RunCamera};
use crate::scene::Scene;
use crate::truth::ObjectVoxels;
use glam::DVec3;
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
    let (mut camera, mut gauge) = (RunCamera::new(scene), Gauge::new(scene, object));
    let capture = |next: &NextView| camera.capture(next);
    let measure = |session: &Session, frame: &Frame, truth| gauge.measure(session, frame, truth);
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
