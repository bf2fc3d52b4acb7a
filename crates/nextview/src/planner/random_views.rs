use super::{Choice, Plan, Situation, ViewPlanner};
use crate::Error;
use crate::geometry::random::Random;

/// Takes a random view among the open ones: the baseline. Each seed gives one sequence of views, whatever the
/// camera sees.
#[derive(Clone, Copy, Debug)]
pub struct RandomViews {
    /// Seed of the sequence.
    pub seed: u64,
}

impl ViewPlanner for RandomViews {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let open = situation.open_views();
        if open.is_empty() {
            return Ok(Plan::default());
        }
        let view = open[Random::new(self.seed, situation.visited().len() as u64).index(open.len())];
        Ok(Plan { choice: Some(Choice::new(view, 0.0)), ..Plan::default() })
    }
}
