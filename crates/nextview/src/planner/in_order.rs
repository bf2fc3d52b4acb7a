use super::{Choice, Plan, Situation, ViewPlanner};

/// Takes the views in the order of their numbers, and begins anew after the last: that of a recording, to compare with.
#[derive(Clone, Copy, Debug)]
pub struct InOrder;

impl ViewPlanner for InOrder {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let open = situation.open_views();
        let last = situation.visited.last();
        let next = open.iter().find(|view| last.is_none_or(|last| *view > last)).or(open.first());
        let choice = |&view| Choice { view, score: 0.0, local_share: 0.0, flow_share: 0.0, runner_up: None };
        Plan { choice: next.map(choice), ..Plan::default() }
    }
}
