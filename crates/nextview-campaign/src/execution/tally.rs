use super::CampaignEvent;
use crate::RunRecord;
use crate::store::Store;
use nextview_scan::Fault;
use std::collections::BTreeMap;

/// Numbers of open and failed runs of each object.
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
    /// Counts the runs of this store's share, some of which may have records.
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

    /// Returns the messages about the runs of this store before the first run.
    pub fn beginning(&self, store: &Store) -> Vec<CampaignEvent> {
        let torn = "the last line of runs.jsonl is incomplete; its run is repeated";
        let note = store.was_torn().then(|| CampaignEvent::Note(torn.to_owned()));
        let n_runs = self.objects.values().map(|count| count.n_runs).sum();
        let (n_objects, n_finished) = (self.objects.len(), n_runs - self.n_left());
        note.into_iter().chain([CampaignEvent::Began { n_objects, n_runs, n_finished }]).collect()
    }

    /// Returns the number of runs without a record.
    pub fn n_left(&self) -> usize {
        self.objects.values().map(|count| count.n_left).sum()
    }

    /// Stores a record, counts its run, and returns the events. A record that is already stored causes none.
    pub fn keep(&mut self, store: &mut Store, record: &RunRecord) -> Result<Vec<CampaignEvent>, Fault> {
        let is_known = store.runs().number(&record.id()).is_some_and(|number| store.is_finished(number));
        store.append(record)?;
        if is_known {
            return Ok(Vec::new());
        }
        let failure = record.failure().map(str::to_owned);
        let finished = CampaignEvent::RunFinished { run: record.id(), failure };
        Ok([finished].into_iter().chain(self.add(record)).collect())
    }

    /// Counts a run, and returns an event if it was the last of its object.
    fn add(&mut self, record: &RunRecord) -> Option<CampaignEvent> {
        let count = self.objects.get_mut(&record.object)?;
        count.n_left = count.n_left.saturating_sub(1);
        count.n_failed += usize::from(record.failure().is_some());
        let Count { n_runs, n_left, n_failed } = *count;
        let object = record.object.clone();
        (n_left == 0).then_some(CampaignEvent::ObjectFinished { object, n_runs, n_failed })
    }
}
