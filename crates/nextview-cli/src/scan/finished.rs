use crate::Failure;
use nextview::geometry::Aabb;
use nextview::session::{Session, StopReason};
use nextview_sim::accuracy::Accuracy;
use nextview_sim::gauge::Measures;
use nextview_sim::run::Step;
use std::ops::ControlFlow;
use std::time::Instant;

/// A scan that is over.
pub(crate) struct FinishedScan<M = Measures> {
    pub session: Session,
    /// The box around the object.
    pub bounds: Aabb,
    pub steps: Vec<Step<M>>,
    pub stop_reason: StopReason,
}

/// What is known of how good a scan is after a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measured {
    /// None where the true object is not known.
    pub truth: Option<Measures>,
    /// Of recordings whose truth is known.
    pub accuracy: Option<Accuracy>,
}

impl From<Measures> for Measured {
    fn from(truth: Measures) -> Self {
        Self { truth: Some(truth), accuracy: None }
    }
}

impl FinishedScan {
    /// The same scan as those are told whose truth may not be known.
    pub(super) fn told(self) -> FinishedScan<Measured> {
        let steps = self.steps.into_iter().map(|step| step.map(Measured::from)).collect();
        let Self { session, bounds, stop_reason, .. } = self;
        FinishedScan { session, bounds, steps, stop_reason }
    }
}

/// Collects the steps of a run, which is told what to do with each, and ends it when the time is over.
pub(super) fn collect<M>(
    time_limit_s: Option<f64>,
    tell: impl Fn(&Step<M>) -> Result<(), Failure>,
    run: impl FnOnce(&mut dyn FnMut(Step<M>) -> ControlFlow<StopReason>) -> Result<StopReason, Failure>,
) -> Result<(Vec<Step<M>>, StopReason), Failure> {
    let mut steps = Vec::new();
    let mut told = Ok(());
    let start = Instant::now();
    let stop_reason = run(&mut |step| {
        if told.is_ok() {
            told = tell(&step);
        }
        steps.push(step);
        let is_over = time_limit_s.is_some_and(|limit| start.elapsed().as_secs_f64() >= limit);
        if is_over { ControlFlow::Break(StopReason::TimeLimit) } else { ControlFlow::Continue(()) }
    });
    let stop_reason = stop_reason?;
    told.map(|()| (steps, stop_reason))
}
