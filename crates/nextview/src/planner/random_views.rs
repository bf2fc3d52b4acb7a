use super::{Choice, Plan, Situation, ViewPlanner};
use crate::geometry::random::Random;

/// Takes a view at random among those not yet visited: the baseline. Every seed gives one sequence of views, whatever
/// the camera sees.
#[derive(Clone, Copy, Debug)]
pub struct RandomViews {
    /// Which sequence.
    pub seed: u64,
}

impl ViewPlanner for RandomViews {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let open = situation.open_views();
        if open.is_empty() {
            return Plan::default();
        }
        let view = open[Random::new(self.seed, situation.visited.len() as u64).index(open.len())];
        let choice = Choice { view, score: 0.0, local_share: 0.0, flow_share: 0.0, runner_up: None };
        Plan { choice: Some(choice), ..Plan::default() }
    }
}
