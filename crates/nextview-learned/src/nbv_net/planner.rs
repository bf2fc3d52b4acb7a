use super::network::Network;
use super::views::{DIRECTIONS, N_VIEWS};
use crate::fixed_views;
use crate::grid::Grid;
use nextview::Error;
use nextview::planner::{Plan, Situation, ViewPlanner};

/// Takes the view that NBV-Net chooses.
///
/// Each of its 14 [`views`](super::views) stands for the nearest view candidate (the first on ties), visited
/// or not; views that stand for a visited one are skipped. The planner therefore takes at most 14 candidates,
/// however many there are, and then chooses none.
#[derive(Clone, Debug, Default)]
pub struct NbvNet {
    network: Network,
}

impl NbvNet {
    /// Creates a planner with a custom network.
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
