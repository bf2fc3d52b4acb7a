use super::RUNS;
use super::known_runs::KnownRuns;
use super::records::{in_line, records};
use crate::{RunRecord, Spec};
use nextview_scan::{Fault, Faults};
use std::fs;
use std::path::Path;

/// The runs of a campaign so far.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredRuns {
    /// Name of the campaign's folder.
    pub name: String,
    /// Each run once, in the order of [`RunId`](crate::RunId).
    pub runs: Vec<RunRecord>,
    /// Whether the last line of the file was not whole and was left out: the campaign may be running.
    pub torn: bool,
}

/// Reads all runs in a campaign's folder, also while the campaign runs. Fails if there is none yet, at a line
/// that is no record, and if two records of one run are not equal.
pub fn read(dir: &Path) -> Result<StoredRuns, Faults> {
    let path = dir.join(RUNS);
    let mut records = records(dir)?;
    let mut known = KnownRuns::default();
    for stored in records.by_ref() {
        let stored = stored?;
        let line = stored.line;
        known.add(stored).map_err(|fault| in_line(fault, line, &path))?;
    }
    let runs: Vec<RunRecord> = known.into_records().collect();
    if runs.is_empty() {
        let fault = Fault::data("holds no finished run").in_file(&path);
        return Err(fault.with_remedy("wait until the campaign has finished its first run").into());
    }
    Ok(StoredRuns { name: name(dir), runs, torn: records.is_torn() })
}

/// The configuration of the run in a row, from 1, of a campaign's table `runs`, as a scan reads it: with the
/// seeds that the run drew from, so that the scan is the same. Fails if there is no such row or its run is
/// not done yet.
pub fn config_of_row(dir: &Path, row: usize) -> Result<String, Faults> {
    let runs = Spec::of_folder(dir)?.runs()?;
    let run = row.checked_sub(1).and_then(|i| runs.get(i)).ok_or_else(|| {
        let (n, table) = (runs.len(), dir.join("runs.csv"));
        Fault::request(format!("there is no row {row}, expected 1 to {n} as in {}", table.display()))
    })?;
    let stored = read(dir)?;
    let record = stored.runs.iter().find(|record| record.id() == run.id).ok_or_else(|| {
        let fault = Fault::data(format!("{} has not been run yet", run.id)).in_file(&dir.join(RUNS));
        fault.with_remedy("wait for the campaign, or resume it (`resume`)")
    })?;
    Ok(toml::to_string(&record.config).map_err(Fault::data)?)
}

fn name(dir: &Path) -> String {
    let full = fs::canonicalize(dir).unwrap_or_else(|_| dir.to_owned());
    full.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
