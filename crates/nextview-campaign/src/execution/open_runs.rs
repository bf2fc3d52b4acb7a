use super::tally::Tally;
use super::{Listener, WorkSource};
use crate::store::Store;
use crate::{Run, RunRecord};
use nextview_scan::Fault;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The runs that have no record yet, of a campaign or of a shard of it. Their records go to the campaign's
/// store, and events to a listener.
pub struct OpenRuns<'a> {
    /// Numbers of runs with a common object.
    groups: Mutex<VecDeque<Vec<usize>>>,
    /// Records are stored and reported one at a time.
    kept: Mutex<(&'a mut Store, Tally)>,
    listener: Listener<'a>,
}

impl<'a> OpenRuns<'a> {
    /// Takes the open runs of this store.
    pub fn new(store: &'a mut Store, listener: Listener<'a>) -> Self {
        let groups = store.open_groups().into();
        let tally = Tally::new(store);
        Self { groups: Mutex::new(groups), kept: Mutex::new((store, tally)), listener }
    }
}

impl WorkSource for OpenRuns<'_> {
    fn take(&self) -> Result<Option<Vec<Run>>, Fault> {
        let Some(numbers) = lock(&self.groups).pop_front() else { return Ok(None) };
        let kept = lock(&self.kept);
        Ok(Some(numbers.into_iter().filter_map(|number| kept.0.runs().get(number)).collect()))
    }

    fn finish(&self, record: RunRecord) -> Result<(), Fault> {
        let mut kept = lock(&self.kept);
        let (store, tally) = &mut *kept;
        tally.keep(store, &record)?.into_iter().for_each(self.listener);
        Ok(())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
