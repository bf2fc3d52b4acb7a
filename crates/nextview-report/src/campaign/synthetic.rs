//! Synthetic campaigns for tests.

use nextview_campaign::store::{StoredRuns, read};
use nextview_campaign::{DoneRun, Host, RunRecord, RunResult};
use nextview_scan::{BuildIdentity, ScanRecord};
use std::sync::atomic::{AtomicUsize, Ordering};

#[path = "../../../nextview-campaign/src/synthetic_runs.rs"]
mod runs;

/// A mutable campaign in memory.
#[derive(Clone)]
pub(crate) struct Campaign {
    pub name: String,
    pub runs: Vec<RunRecord>,
    pub torn: bool,
}

impl Campaign {
    /// Passes the campaign, as stored in a folder, to `make`.
    pub fn stored<T>(&self, make: impl FnOnce(&StoredRuns) -> T) -> T {
        static NUMBER: AtomicUsize = AtomicUsize::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("nextview-report-{number}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let lines = self.runs.iter().map(|run| serde_json::to_string(run).unwrap() + "\n");
        std::fs::write(folder.join("runs.jsonl"), lines.collect::<String>()).unwrap();
        let stored = StoredRuns { name: self.name.clone(), torn: self.torn, ..read(&folder).unwrap() };
        let made = make(&stored);
        std::fs::remove_dir_all(&folder).unwrap();
        made
    }
}

/// A campaign of these variants, each better than the one before, on the first `n_objects` of six objects.
pub(crate) fn campaign(variants: &[&str], n_objects: usize) -> Campaign {
    let build = BuildIdentity { version: "0.0.0".to_owned(), source: "made-up".to_owned() };
    let of_build = |run| RunRecord { build: build.clone(), ..run };
    let runs = runs::campaign(variants, n_objects).into_iter().map(of_build).collect();
    Campaign { name: "made-up".to_owned(), runs, torn: false }
}

/// The record of a run, mutable.
pub(crate) fn record_mut(run: &mut RunRecord) -> &mut ScanRecord {
    match &mut run.result {
        RunResult::Done(done) => &mut done.record,
        RunResult::Failed(reason) => panic!("{reason}"),
    }
}
