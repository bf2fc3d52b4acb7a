use super::tally::Tally;
use super::{Batch, CampaignEvent};
use crate::store::Store;
use crate::{FailedRuns, RunRecord, tables};
use nextview_scan::{Fault, Faults};
use std::collections::VecDeque;

/// Number of parts of a worker's share below which runs with a common object are not divided.
const PARTS_OF_SHARE: usize = 8;
/// Maximum number of missing runs listed by name.
const MAX_NAMED: usize = 3;

/// The open runs of a campaign for workers in other processes: hands out batches, and stores the returned
/// records. The code that starts the workers decides how to handle a lost batch. Runs still missing at the
/// end stay open for the next process that opens the store.
///
/// ```no_run
/// # use nextview::Cancel;
/// # use nextview_campaign::{Shard, Spec, execution::{Batch, Dispatch}, store::Store};
/// # fn main() -> Result<(), nextview_scan::Faults> {
/// let spec = Spec::load("mine.toml", &[])?;
/// let mut dispatch = Dispatch::new(Store::open("mine".as_ref(), &spec, Shard::WHOLE, true)?);
/// while let Some(batch) = dispatch.take(8) {
///     let text = batch.to_json()?;
///     // In another process:
///     let mut runs = Batch::from_json(&text)?.begin(1, None)?;
///     while let Some(record) = runs.next_record(&Cancel::default())? {
///         // And back:
///         dispatch.keep(&record)?;
///     }
/// }
/// dispatch.finish()?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Dispatch {
    store: Store,
    tally: Tally,
    /// Numbers of runs with a common object, not yet in a batch.
    groups: VecDeque<Vec<usize>>,
    /// Number of open runs at the beginning.
    n_open: usize,
    /// Number of those not yet in a batch.
    n_waiting: usize,
}

impl Dispatch {
    /// Takes the open runs of this store.
    pub fn new(store: Store) -> Self {
        let (groups, tally) = (store.open_groups().into(), Tally::new(&store));
        let n_open = tally.n_left();
        Self { n_open, n_waiting: n_open, store, tally, groups }
    }

    /// Returns the messages before the first batch.
    pub fn beginning(&self) -> Vec<CampaignEvent> {
        self.tally.beginning(&self.store)
    }

    /// Returns the next runs; `None` if all were handed out. Runs with a common object stay together, unless
    /// they exceed a worker's share of the waiting runs: guided self-scheduling (Polychronopoulos & Kuck
    /// 1987), with which all workers end at about the same time.
    pub fn take(&mut self, n_workers: usize) -> Option<Batch> {
        let group = self.groups.pop_front()?;
        let n_workers = n_workers.max(1);
        let n_least = self.n_open.div_ceil(PARTS_OF_SHARE * n_workers);
        let n_most = self.n_waiting.div_ceil(n_workers).max(n_least).max(1);
        let n_parts = group.len().div_ceil(n_most).max(1);
        let (part, rest) = group.split_at(group.len().div_ceil(n_parts));
        self.n_waiting -= part.len();
        if !rest.is_empty() {
            self.groups.push_front(rest.to_vec());
        }
        Some(Batch::new(part.iter().filter_map(|&number| self.store.runs().get(number)).collect()))
    }

    /// Stores a record, on disk when this returns. A record equal to a stored one changes nothing.
    pub fn keep(&mut self, record: &RunRecord) -> Result<Vec<CampaignEvent>, Fault> {
        self.tally.keep(&mut self.store, record)
    }

    /// Writes the tables if every run has its record, and returns the failed runs.
    pub fn finish(&self) -> Result<Vec<FailedRuns>, Faults> {
        let (runs, missing) = (self.store.runs(), self.store.open_groups().concat());
        if !missing.is_empty() {
            let named = missing.iter().take(MAX_NAMED).filter_map(|&number| Some(runs.get(number)?.id));
            let named: String = named.map(|id| format!("\n  {id}")).collect();
            let more = if missing.len() > MAX_NAMED { "\n  ..." } else { "" };
            let n_runs: usize = self.store.share().iter().map(Vec::len).sum();
            let message = format!("{} of {n_runs} runs have no record:{named}{more}", missing.len());
            let remedy = "resume the campaign to run them (`resume`)";
            return Err(Fault::data(message).in_file(self.store.dir()).with_remedy(remedy).into());
        }
        tables::write(self.store.dir(), &self.store.finished())?;
        Ok(self.store.failed())
    }
}
