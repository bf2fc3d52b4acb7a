use super::network::Network;
use super::views::{DIRECTIONS, N_VIEWS};
use crate::fixed_views;
use crate::grid::Grid;
use nextview::Error;
use nextview::planner::{Plan, Situation, ViewPlanner};

/// Takes the view that NBV-Net chooses.
///
/// Each of its 14 [`views`](super::views) stands for the view candidate nearest to it (the first on ties),
/// visited or not; it skips views that stand for a visited one. So it takes 14 candidates at most, however
/// many there are, and then none.
#[derive(Clone, Debug, Default)]
pub struct NbvNet {
    network: Network,
}

impl NbvNet {
    /// A planner with weights of your own.
    pub fn new(network: Network) -> Self {
        Self { network }
    }
}

impl ViewPlanner for NbvNet {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let stand_ins = fixed_views::stand_ins(situation, &DIRECTIONS);
        situation.cancel().check()?;
        let logits = self.network.logits(&Grid::new(situation.snapshot()));
        let scores = probabilities(&logits).map(Some);
        Ok(Plan { choice: fixed_views::choice(situation, &stand_ins, &scores), ..Plan::default() })
    }
}

/// The probability that each view is the best one, according to the network.
fn probabilities(logits: &[f32; N_VIEWS]) -> [f64; N_VIEWS] {
    let largest = logits.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
    let odds = logits.map(|logit| f64::from(logit - largest).exp());
    let total: f64 = odds.iter().sum();
    odds.map(|odds| odds / total)
}
