use super::CampaignEvent;
use crate::{Run, RunRecord};
use std::collections::BTreeMap;

/// How many runs of each object are left and how many failed.
#[derive(Debug)]
pub(super) struct Tally {
    objects: BTreeMap<String, Count>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    n_runs: usize,
    n_left: usize,
    n_failed: usize,
}

impl Tally {
    /// Of these runs, some of which have records.
    pub fn new(runs: &[Run], records: &[Option<RunRecord>]) -> Self {
        let mut objects: BTreeMap<String, Count> = BTreeMap::new();
        for (run, record) in runs.iter().zip(records) {
            let count = objects.entry(run.id.object.clone()).or_default();
            count.n_runs += 1;
            count.n_left += usize::from(record.is_none());
            count.n_failed += usize::from(record.as_ref().is_some_and(|record| record.failure().is_some()));
        }
        Self { objects }
    }

    /// Counts a run; an event if it was the last of its object.
    pub fn add(&mut self, record: &RunRecord) -> Option<CampaignEvent> {
        let count = self.objects.get_mut(&record.object)?;
        count.n_left = count.n_left.saturating_sub(1);
        count.n_failed += usize::from(record.failure().is_some());
        let Count { n_runs, n_left, n_failed } = *count;
        let object = record.object.clone();
        (n_left == 0).then_some(CampaignEvent::ObjectFinished { object, n_runs, n_failed })
    }
}
