use super::{Batch, BatchConfig, BatchView, EvenViews, Leg, Situation, ViewPlanner};
use crate::Cancelled;

/// The planners that answer where a session's own planner has nothing to say.
pub struct Fallback {
    /// Plans the next view if the session's planner chooses none while nothing of the box was seen. Default:
    /// [`EvenViews`].
    pub view: Box<dyn ViewPlanner>,
    /// Plans the legs after the next view if the session's planner chooses one view at a time. Default:
    /// [`Batch::plan_after`].
    pub legs: PlanLegs,
}

/// Returns the legs after this view (number of a candidate): at most as many as the last argument, which is
/// at least 1.
pub type PlanLegs = fn(&Situation<'_>, usize, usize) -> Result<Vec<Leg>, Cancelled>;

impl Default for Fallback {
    fn default() -> Self {
        Self { view: Box::new(EvenViews), legs: batch_after }
    }
}

fn batch_after(situation: &Situation<'_>, view: usize, n_views: usize) -> Result<Vec<Leg>, Cancelled> {
    let batch = Batch::new(BatchConfig { n_views, ..BatchConfig::default() }).expect("at least one view");
    Ok(batch.plan_after(situation, view)?.iter().map(BatchView::leg).collect())
}
