//! The loop of a simulated scan.

use glam::DVec2;
use nextview::sensor::{Frame, Intrinsics};
use nextview::session::{Decision, Session, StepReport, StopReason};
use nextview_sim::evaluator::{Evaluator, Measures, capture};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;

/// A step of a scan, measured against the truth.
pub struct Step {
    pub report: StepReport,
    /// With the pose in which it was mapped.
    pub frame: Frame,
    pub measures: Measures,
}

/// A camera with the lens of the D435i and a quarter of its pixels, for tests that do not need them all.
pub fn small_camera() -> Intrinsics {
    let pinhole = Intrinsics::pinhole(320, 240, DVec2::splat(305.0), DVec2::new(159.5, 119.5)).unwrap();
    pinhole.with_distortion(Intrinsics::d435i().distortion()).unwrap()
}

/// Scans until the session stops.
pub fn scan(session: &mut Session, scene: &Scene, object: &ObjectVoxels) -> (Vec<Step>, StopReason) {
    let mut evaluator = Evaluator::new(scene, object);
    let mut steps = Vec::new();
    loop {
        let next = match session.decide().unwrap() {
            Decision::Move(next) => next,
            Decision::Stop(reason) => return (steps, reason),
        };
        let (frame, truth) =
            capture(scene, &next.world_from_camera, steps.is_empty()).expect("candidates are in the room");
        let report = session.observe(&frame).unwrap();
        let frame = frame.with_pose(report.world_from_camera);
        let measures = evaluator.measure(session, &frame, truth);
        steps.push(Step { report, frame, measures });
    }
}
