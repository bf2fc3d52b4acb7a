use super::network::Network;
use crate::grid::Grid;
use glam::DVec3;
use nextview::Error;
use nextview::planner::{Choice, Plan, Situation, ViewPlanner};

/// Takes the view nearest to the network's direction: the unvisited reachable candidate with the smallest
/// angle at the middle of the box, the first on ties.
///
/// The score is the cosine of that angle, at most 1.
#[derive(Clone, Debug, Default)]
pub struct NbvRegression {
    network: Network,
}

impl ViewPlanner for NbvRegression {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let direction = self.network.direction(&Grid::new(situation.snapshot()));
        Ok(Plan { choice: nearest(situation, direction), ..Plan::default() })
    }
}

/// The open candidate with the smallest angle to this direction, and the second one.
fn nearest(situation: &Situation<'_>, direction: DVec3) -> Option<Choice> {
    let snapshot = situation.snapshot();
    let center = snapshot.lattice().bounds(&snapshot.block()).center();
    let cosine = |view: usize| {
        let offset = situation.views().pose(view).translation() - center;
        offset.try_normalize().map_or(-1.0, |offset| offset.dot(direction))
    };
    let mut ranked: Vec<(usize, f64)> =
        situation.open_views().into_iter().map(|view| (view, cosine(view))).collect();
    ranked.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let &(best, score) = ranked.first()?;
    Some(Choice { runner_up: ranked.get(1).map(|&(second, _)| second), ..Choice::new(best, score) })
}
