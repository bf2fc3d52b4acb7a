use super::RUNS;
use super::conflict::check_repeated;
use super::records::{Position, in_line, records};
use super::run_records::RunRecords;
use crate::{RunId, Spec};
use nextview_scan::{Fault, Faults};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::slice;

/// The stored runs of a campaign.
#[derive(Clone, Debug)]
pub struct StoredRuns {
    /// Name of the campaign's folder.
    pub name: String,
    /// Each run once, in the order of [`RunId`].
    pub runs: RunRecords,
    /// Labels of their variants.
    pub variants: BTreeSet<String>,
    /// Whether the last line of the file was incomplete and was left out: the campaign may be running.
    pub torn: bool,
}

/// Finds all runs in a campaign's folder, even while the campaign runs. Fails if there is none, at a line
/// that is not a record, and if two records of one run are not equal.
pub fn read(dir: &Path) -> Result<StoredRuns, Faults> {
    let path = dir.join(RUNS);
    let mut records = records(dir)?;
    let mut known: BTreeMap<RunId, Position> = BTreeMap::new();
    for stored in records.by_ref() {
        let stored = stored?;
        let id = stored.record.id();
        if let Some(&known) = known.get(&id) {
            let checked = check_repeated(slice::from_ref(&path), known, &stored);
            checked.map_err(|fault| in_line(fault, stored.line, &path))?;
        } else {
            known.insert(id, stored.position);
        }
    }
    if known.is_empty() {
        let fault = Fault::data("holds no finished run").in_file(&path);
        return Err(fault.with_remedy("wait until the campaign has finished its first run").into());
    }
    let variants = known.keys().map(|id| id.variant.clone()).collect();
    let runs = RunRecords::new(vec![path], known.into_values().collect());
    Ok(StoredRuns { name: name(dir), runs, variants, torn: records.is_torn() })
}

/// Returns the scan configuration of the run in a row, from 1, of a campaign's table `runs`. It has the seeds
/// of the run's draws, so the scan is the same. Fails if there is no such row or its run is not done.
pub fn config_of_row(dir: &Path, row: usize) -> Result<String, Faults> {
    let runs = Spec::of_folder(dir)?.runs()?;
    let run = row.checked_sub(1).and_then(|number| runs.get(number)).ok_or_else(|| {
        let (n, table) = (runs.len(), dir.join("runs.csv"));
        Fault::request(format!("there is no row {row}, expected 1 to {n} as in {}", table.display()))
    })?;
    for stored in records(dir)? {
        let record = stored?.record;
        if record.id() == run.id {
            return Ok(toml::to_string(&record.config).map_err(Fault::data)?);
        }
    }
    let fault = Fault::data(format!("{} has not been run yet", run.id)).in_file(&dir.join(RUNS));
    Err(fault.with_remedy("wait for the campaign, or resume it (`resume`)").into())
}

fn name(dir: &Path) -> String {
    let full = fs::canonicalize(dir).unwrap_or_else(|_| dir.to_owned());
    full.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
