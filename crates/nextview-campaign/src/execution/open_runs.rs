use super::tally::Tally;
use super::{CampaignEvent, Listener, WorkSource};
use crate::store::Store;
use crate::{Run, RunRecord};
use nextview_scan::{Fault, ScanConfig};
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The runs of a campaign that have no record yet; records go to its store, events to a listener.
pub struct OpenRuns<'a> {
    groups: Mutex<VecDeque<Vec<Run>>>,
    /// Records are kept and reported one at a time.
    kept: Mutex<(&'a mut Store, Tally)>,
    listener: Listener<'a>,
}

impl<'a> OpenRuns<'a> {
    /// The open runs of this store.
    pub fn new(store: &'a mut Store, listener: Listener<'a>) -> Self {
        let open = store.runs().iter().zip(store.records()).filter(|(_, record)| record.is_none());
        let groups = grouped(open.map(|(run, _)| run));
        let tally = Tally::new(store.runs(), store.records());
        Self { groups: Mutex::new(groups.into()), kept: Mutex::new((store, tally)), listener }
    }
}

impl WorkSource for OpenRuns<'_> {
    fn take(&self) -> Result<Option<Vec<Run>>, Fault> {
        Ok(lock(&self.groups).pop_front())
    }

    fn finish(&self, record: RunRecord) -> Result<(), Fault> {
        let mut kept = lock(&self.kept);
        let (store, tally) = &mut *kept;
        store.append(&record)?;
        let failure = record.failure().map(str::to_owned);
        let object_finished = tally.add(&record);
        (self.listener)(CampaignEvent::RunFinished { run: record.id(), failure });
        object_finished.into_iter().for_each(self.listener);
        Ok(())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The runs by the object that they share, in the order in which the objects first come.
fn grouped<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<Vec<Run>> {
    let mut groups: Vec<(ScanConfig, Vec<Run>)> = Vec::new();
    for run in runs {
        let object = run.config.of_object();
        match groups.iter_mut().rev().find(|(known, _)| *known == object) {
            Some((_, group)) => group.push(run.clone()),
            None => groups.push((object, vec![run.clone()])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}
