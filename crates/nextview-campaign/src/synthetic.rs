//! Synthetic campaigns for tests.

use crate::store::{StoredRuns, read};
use crate::{DoneRun, Host, RunRecord, RunResult};
use nextview_scan::StepRecord;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

#[path = "synthetic_runs.rs"]
mod runs;

pub(crate) use runs::campaign;

/// The measures of a run, mutable.
pub(crate) fn done_mut(run: &mut RunRecord) -> &mut DoneRun {
    match &mut run.result {
        RunResult::Done(done) => done,
        RunResult::Failed(reason) => panic!("{reason}"),
    }
}

/// The steps of a run, mutable.
pub(crate) fn steps_mut(run: &mut RunRecord) -> &mut Vec<StepRecord> {
    &mut done_mut(run).record.steps
}

/// An empty folder.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("nextview-campaign-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A folder with these records, removed at the end, and its stored runs.
pub(crate) fn stored(name: &str, runs: &[RunRecord]) -> (FolderGuard, StoredRuns) {
    static NUMBER: AtomicUsize = AtomicUsize::new(0);
    let folder = folder(&format!("{name}-{}", NUMBER.fetch_add(1, Ordering::Relaxed)));
    let lines = runs.iter().map(|run| serde_json::to_string(run).unwrap() + "\n");
    std::fs::write(folder.join("runs.jsonl"), lines.collect::<String>()).unwrap();
    let stored = read(&folder).unwrap();
    (FolderGuard(folder), stored)
}

/// Removes its folder.
pub(crate) struct FolderGuard(PathBuf);

impl Drop for FolderGuard {
    fn drop(&mut self) {
        // Others clean the temporary folder, too.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
