use super::cloud::Cloud;
use super::network::Network;
use super::views::{self, DIRECTIONS};
use crate::fixed_views;
use nextview::Error;
use nextview::planner::{Plan, Situation, ViewPlanner};

/// Takes the view for which PC-NBV predicts most new surface, among those that were not visited.
///
/// Each of its 33 [`views`] stands for the view candidate nearest to it (the first on ties), visited or not.
/// A view was visited if its candidate was, or if it is the nearest in angle to a candidate that was. So the
/// planner takes 33 candidates at most, however many there are, and then none. The score is the share of the
/// surface that the view would newly show, according to the network.
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
