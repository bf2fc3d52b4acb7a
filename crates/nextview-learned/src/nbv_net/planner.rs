use super::grid::Grid;
use super::network::Network;
use super::views::{self, N_VIEWS};
use nextview::Error;
use nextview::planner::{Choice, Plan, Situation, ViewPlanner};

/// Takes the view that NBV-Net chooses.
///
/// Each of its 14 [`views`] stands for the view candidate nearest to it (the first on ties), visited or not;
/// it skips views that stand for a visited one. So it takes 14 candidates at most, however many there are,
/// and then none.
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
        let stand_ins = stand_ins(situation);
        situation.cancel().check()?;
        let logits = self.network.logits(&Grid::new(situation.snapshot()));
        let mut ranked: Vec<usize> = (0..N_VIEWS).collect();
        ranked.sort_by(|&a, &b| logits[b].total_cmp(&logits[a]).then(a.cmp(&b)));
        let probability = probabilities(&logits);
        let is_open = |candidate: &usize| !situation.visited().contains(candidate);
        let mut open = ranked.iter().filter_map(|&view| Some((stand_ins[view].filter(is_open)?, view)));
        let choice = open.next().map(|(candidate, view)| Choice {
            runner_up: open.map(|(other, _)| other).find(|&other| other != candidate),
            ..Choice::new(candidate, probability[view])
        });
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// The candidate within reach that is nearest to each view; none if there is no candidate within reach.
fn stand_ins(situation: &Situation<'_>) -> [Option<usize>; N_VIEWS] {
    let (snapshot, views) = (situation.snapshot(), situation.views());
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    views::positions(&bounds).map(|position| {
        let candidates = (0..views.len()).filter(|&view| situation.can_go(view));
        let distances =
            candidates.map(|view| (views.pose(view).translation().distance_squared(position), view));
        distances.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, view)| view)
    })
}

/// The probability that each view is the best one, according to the network.
fn probabilities(logits: &[f32; N_VIEWS]) -> [f64; N_VIEWS] {
    let largest = logits.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
    let odds = logits.map(|logit| f64::from(logit - largest).exp());
    let total: f64 = odds.iter().sum();
    odds.map(|odds| odds / total)
}
