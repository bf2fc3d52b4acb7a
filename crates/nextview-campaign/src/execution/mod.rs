//! Doing runs: several beside each other, from wherever work comes.
//!
//! [`run_campaign`] does what is left of a campaign in a folder. Beneath it, [`execute`] takes runs from a
//! [`WorkSource`] and hands their records back to it, and knows neither specification nor folder: a source
//! may as well lease runs from another machine.

mod event;
mod job;
mod open_runs;
mod queue;
mod run;
mod tally;
mod work_source;

pub use event::{CampaignEvent, Listener};
pub use job::execute;
pub use open_runs::OpenRuns;
pub use work_source::{RunList, WorkSource};

use crate::store::Store;
use nextview::Cancel;
use nextview_scan::Fault;

/// Does all open runs of a campaign, or of the store's shard of it, `n_jobs` beside each other, by default
/// one per thread.
///
/// A run that fails is recorded with its reason and does not stop the others. If this is cancelled, runs that
/// are finished are kept, and all others stay open.
pub fn run_campaign(
    store: &mut Store,
    n_jobs: Option<usize>,
    cancel: &Cancel,
    listener: Listener<'_>,
) -> Result<(), Fault> {
    let share = || store.share().iter().flatten();
    let n_runs = share().count();
    let n_finished = share().filter(|&&number| store.is_finished(number)).count();
    if store.was_torn() {
        listener(CampaignEvent::Note(
            "the last line of runs.jsonl is not whole; its run is done again".to_owned(),
        ));
    }
    let n_objects = count_objects(store);
    listener(CampaignEvent::Began { n_objects, n_runs, n_finished });
    let n_jobs = n_jobs.unwrap_or_else(rayon::current_num_threads).clamp(1, (n_runs - n_finished).max(1));
    execute(&OpenRuns::new(store, listener), n_jobs, cancel)
}

/// Number of objects with runs in the store's share.
fn count_objects(store: &Store) -> usize {
    let mut objects: Vec<usize> =
        store.share().iter().flatten().map(|number| number / store.runs().n_of_object()).collect();
    objects.sort_unstable();
    objects.dedup();
    objects.len()
}
