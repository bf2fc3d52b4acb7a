use super::CampaignEvent;
use crate::RunRecord;
use crate::store::Store;
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
    /// Of the runs of this store's share, some of which have records.
    pub fn new(store: &Store) -> Self {
        let mut objects: BTreeMap<String, Count> = BTreeMap::new();
        let mut add = |object: &str, n_runs: usize, n_left: usize| {
            let count = objects.entry(object.to_owned()).or_default();
            count.n_runs += n_runs;
            count.n_left += n_left;
        };
        for group in store.share() {
            let first = group.first().and_then(|&number| store.runs().get(number));
            let n_left = group.iter().filter(|&&number| !store.is_finished(number)).count();
            first.iter().for_each(|run| add(&run.id.object, group.len(), n_left));
        }
        for failed in store.failed() {
            if let Some(count) = objects.get_mut(&failed.object) {
                count.n_failed += failed.n_runs;
            }
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
