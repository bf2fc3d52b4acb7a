//! Execution of runs, several in parallel, from any source of work.
//!
//! [`run_campaign`] executes the remaining runs of a campaign in a folder. At a lower level, [`execute`]
//! takes runs from a [`WorkSource`] and returns their records to it. It knows neither specification nor
//! folder: a source may also lease runs from another machine.
//!
//! For workers in separate processes, a [`Dispatch`] hands out the open runs of a folder as [`Batch`]es,
//! which travel as text, and stores the returned records.

mod batch;
mod dispatch;
mod event;
mod job;
mod open_runs;
mod queue;
mod run;
mod tally;
mod work_source;

pub use batch::{Batch, BatchRuns};
pub use dispatch::Dispatch;
pub use event::{CampaignEvent, Listener};
pub use job::execute;
pub use open_runs::OpenRuns;
pub use work_source::{RunList, WorkSource};

use crate::store::Store;
use nextview::Cancel;
use nextview_scan::{Fault, TruthCache};
use tally::Tally;

/// Executes all open runs of a campaign, or of the store's shard of it, `n_jobs` in parallel: by default, and
/// at most, one per thread. Truths of objects come from the cache, if there is one.
///
/// A failed run is recorded with its reason and does not stop the others. If cancelled, finished runs are
/// stored, and all others stay open.
pub fn run_campaign(
    store: &mut Store,
    n_jobs: Option<usize>,
    truths: Option<&TruthCache>,
    cancel: &Cancel,
    listener: Listener<'_>,
) -> Result<(), Fault> {
    let tally = Tally::new(store);
    tally.beginning(store).into_iter().for_each(listener);
    let n_threads = rayon::current_num_threads();
    // A job needs a thread, and holds an object with its frames.
    let n_jobs = n_jobs.unwrap_or(n_threads).min(n_threads).clamp(1, tally.n_left().max(1));
    execute(&OpenRuns::new(store, listener), n_jobs, truths, cancel)
}
