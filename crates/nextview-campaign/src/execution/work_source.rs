use crate::{Run, RunRecord};
use nextview_scan::Fault;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// A source of runs that receives their records: a campaign's folder, a list, or a lease from elsewhere.
///
/// Runs taken but not finished, because this process is cancelled or ends, become open again: the owner of
/// the leases decides when.
pub trait WorkSource: Sync {
    /// Takes some runs; `None` if there is nothing left. They must have a common object
    /// ([`ScanConfig::of_object`](nextview_scan::ScanConfig::of_object)), which is prepared once for all of
    /// them.
    fn take(&self) -> Result<Option<Vec<Run>>, Fault>;

    /// Receives the record of a taken run. A fault ends the execution.
    fn finish(&self, record: RunRecord) -> Result<(), Fault>;
}

/// Single runs whose records stay in memory, for a process with one run and for tests.
#[derive(Debug, Default)]
pub struct RunList {
    open: Mutex<VecDeque<Run>>,
    finished: Mutex<Vec<RunRecord>>,
}

impl RunList {
    /// Creates a list of these runs, in this order.
    pub fn new(runs: impl IntoIterator<Item = Run>) -> Self {
        Self { open: Mutex::new(runs.into_iter().collect()), finished: Mutex::default() }
    }

    /// Returns the records, in the order in which the runs ended.
    pub fn into_records(self) -> Vec<RunRecord> {
        self.finished.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl WorkSource for RunList {
    fn take(&self) -> Result<Option<Vec<Run>>, Fault> {
        let run = self.open.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        Ok(run.map(|run| vec![run]))
    }

    fn finish(&self, record: RunRecord) -> Result<(), Fault> {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner).push(record);
        Ok(())
    }
}
