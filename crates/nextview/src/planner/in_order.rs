use super::{Choice, Plan, Situation, ViewPlanner};
use crate::Error;

/// Takes the views in the order of their numbers, and starts again after the last: the order of a recording,
/// for comparison.
#[derive(Clone, Copy, Debug)]
pub struct InOrder;

impl ViewPlanner for InOrder {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let open = situation.open_views();
        let last = situation.visited().last();
        let next = open.iter().find(|view| last.is_none_or(|last| *view > last)).or(open.first());
        Ok(Plan { choice: next.map(|&view| Choice::new(view, 0.0)), ..Plan::default() })
    }
}
