use super::cloud::Cloud;
use super::network::Network;
use super::views::{self, DIRECTIONS};
use crate::fixed_views;
use nextview::Error;
use nextview::planner::{Plan, Situation, ViewPlanner};

/// Takes the unvisited view for which PC-NBV predicts the most new surface.
///
/// Each of its 33 [`views`] stands for the nearest view candidate (the first on ties), visited or not. A view
/// is visited if its candidate is, or if it is the nearest in angle to a visited candidate. The planner
/// therefore takes at most 33 candidates, however many there are, and then chooses none. The score is the
/// predicted share of new surface.
#[derive(Clone, Debug, Default)]
pub struct PcNbv {
    network: Network,
}

impl ViewPlanner for PcNbv {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let (snapshot, candidates) = (situation.snapshot(), situation.views());
        let stand_ins = fixed_views::stand_ins(situation, &DIRECTIONS);
        let cloud = Cloud::new(snapshot, situation.cancel())?;
        let bounds = snapshot.lattice().bounds(&snapshot.block());
        let positions = situation.visited().iter().map(|&view| candidates.pose(view).translation());
        let visited = views::visited(&bounds, positions);
        let gains = self.network.gains(&cloud, &visited);
        let open = gains.iter().zip(visited).map(|(&gain, visited)| (!visited).then_some(f64::from(gain)));
        let scores: Vec<Option<f64>> = open.collect();
        Ok(Plan { choice: fixed_views::choice(situation, &stand_ins, &scores), ..Plan::default() })
    }
}
