use super::RUNS;
use super::checks::{check_config, check_same};
use super::conflict::check_repeated;
use super::records::{Position, StoredRecord, in_line, records};
use super::run_records::RunRecords;
use super::staging::Staging;
use crate::failed_runs::FailureCounts;
use crate::{FailedRuns, Runs, Spec, tables};
use nextview_scan::files::{self, Overwrite};
use nextview_scan::{BuildIdentity, Fault, Faults};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Maximum number of faults of one kind listed individually for each folder.
const MAX_NAMED: usize = 3;

/// A campaign merged from several folders.
#[derive(Clone, Debug)]
pub struct Merged {
    /// Number of runs.
    pub n_runs: usize,
    /// Number of equal repetitions of records in the folders.
    pub n_repeated: usize,
    /// Folders whose last line was incomplete and was left out.
    pub torn: Vec<PathBuf>,
    /// Failed runs, by object and reason.
    pub failed: Vec<FailedRuns>,
}

/// Merges the folders of a campaign's shards, as if one process had executed all runs.
///
/// Fails, with all faults, unless the folders have the same specification, their records are of this build,
/// every run of the campaign is present, and repeated records are equal. The result appears as a whole or not
/// at all, and replaces nothing; the folders stay unchanged.
pub fn merge(dirs: &[PathBuf], out: &Path) -> Result<Merged, Faults> {
    let inside = dirs.iter().filter(|dir| files::is_within(out, dir)).map(|dir| {
        let fault = Fault::data(format!("is inside {}, which is an input", dir.display())).in_file(out);
        fault.with_remedy("choose another folder (`out`)")
    });
    Faults::of(inside.collect()).map_or(Ok(()), Err)?;
    let staging = Staging::begin(out)?;
    let mut merging = Merging::begin(dirs)?;
    for (number, dir) in (0..).zip(dirs) {
        merging.read(number, dir);
    }
    let (spec, records, merged) = merging.end()?;
    let to = |name: &str| staging.path().join(name);
    let text = spec.to_toml()?;
    files::write(&to(Spec::FILE), &Overwrite::nothing(), |w| Ok(w.write_all(text.as_bytes())?))?;
    files::write(&to(RUNS), &Overwrite::nothing(), |w| {
        for lines in records.lines() {
            for (_, line) in lines? {
                w.write_all(&line)?;
                w.write_all(b"\n")?;
            }
        }
        Ok(())
    })?;
    tables::write(staging.path(), &records)?;
    staging.publish()?;
    Ok(merged)
}

/// The records found in the folders.
struct Merging {
    spec: Spec,
    runs: Runs,
    /// The files of records.
    files: Vec<PathBuf>,
    /// For each run of the campaign, the place of its record.
    positions: Vec<Option<Position>>,
    failures: FailureCounts,
    n_repeated: usize,
    torn: Vec<PathBuf>,
    faults: Vec<Fault>,
}

impl Merging {
    fn begin(dirs: &[PathBuf]) -> Result<Self, Faults> {
        let first = dirs.first().ok_or_else(|| Fault::request("there are no folders to merge"))?;
        let spec = Spec::of_folder(first).map_err(|faults| faults.map(expect_campaign))?;
        let runs = spec.runs()?;
        Ok(Self {
            files: dirs.iter().map(|dir| dir.join(RUNS)).collect(),
            positions: vec![None; runs.len()],
            spec,
            runs,
            failures: FailureCounts::default(),
            n_repeated: 0,
            torn: Vec::new(),
            faults: Vec::new(),
        })
    }

    /// Reads a folder. Its faults do not stop the others from being read.
    fn read(&mut self, number: u32, dir: &Path) {
        match Spec::of_folder(dir) {
            Ok(spec) => {
                if let Err(fault) = check_same(&self.spec, &spec) {
                    self.faults.push(fault.in_file(&dir.join(Spec::FILE)).with_remedy(
                        "merge the shards of one specification, with the same file paths on all machines",
                    ));
                    return;
                }
            }
            Err(faults) => return self.faults.extend(faults.iter().cloned().map(expect_campaign)),
        }
        let mut records = match records(dir) {
            Ok(records) => records.of_file(number),
            Err(fault) => return self.faults.push(fault),
        };
        let path = dir.join(RUNS);
        let mut other_builds: BTreeMap<String, usize> = BTreeMap::new();
        let mut faults = Vec::new();
        for stored in records.by_ref() {
            let added = stored.and_then(|stored| {
                let build = &stored.record.build;
                if *build != BuildIdentity::this() {
                    *other_builds.entry(build.to_string()).or_default() += 1;
                    return Ok(());
                }
                self.add(&stored).map_err(|fault| in_line(fault, stored.line, &path))
            });
            faults.extend(added.err());
        }
        self.faults.extend(other_builds.into_iter().map(|(build, n)| of_other_build(&build, n, &path)));
        let n_more = faults.len().saturating_sub(MAX_NAMED);
        self.faults.extend(faults.into_iter().take(MAX_NAMED));
        if n_more > 0 {
            self.faults.push(Fault::data(format!("{n_more} more lines are invalid")).in_file(&path));
        }
        if records.is_torn() {
            self.torn.push(dir.to_owned());
        }
    }

    fn add(&mut self, stored: &StoredRecord) -> Result<(), Fault> {
        let id = stored.record.id();
        let missing = || Fault::data(format!("no run of this campaign: {id}"));
        let number = self.runs.number(&id).ok_or_else(missing)?;
        check_config(&self.runs.get(number).ok_or_else(missing)?, &stored.record)?;
        if let Some(known) = self.positions[number] {
            self.n_repeated += 1;
            return check_repeated(&self.files, known, stored);
        }
        self.positions[number] = Some(stored.position);
        self.failures.add(&stored.record);
        Ok(())
    }

    /// Specification and records, in the order of the runs, if there are no faults and no run is missing.
    fn end(mut self) -> Result<(Spec, RunRecords, Merged), Faults> {
        let n_missing = self.positions.iter().filter(|position| position.is_none()).count();
        if n_missing > 0 {
            let n_runs = self.runs.len();
            let missing = self.positions.iter().zip(0..).filter(|(position, _)| position.is_none());
            let named = missing.take(MAX_NAMED).filter_map(|(_, number)| Some(self.runs.get(number)?.id));
            let named: String = named.map(|id| format!("\n  {id}")).collect();
            let more = if n_missing > MAX_NAMED { "\n  ..." } else { "" };
            let message = format!("{n_missing} of {n_runs} runs are missing:{named}{more}");
            let remedy = "merge the folders of all shards, and resume the unfinished ones (`resume`)";
            self.faults.push(Fault::data(message).with_remedy(remedy));
        }
        if let Some(faults) = Faults::of(self.faults) {
            return Err(faults);
        }
        let merged = Merged {
            n_runs: self.runs.len(),
            n_repeated: self.n_repeated,
            torn: self.torn,
            failed: self.failures.list(),
        };
        let positions = self.positions.into_iter().flatten().collect();
        Ok((self.spec, RunRecords::new(self.files, positions), merged))
    }
}

fn of_other_build(build: &str, n_records: usize, path: &Path) -> Fault {
    let this = BuildIdentity::this();
    let message = format!("{n_records} runs were computed by build {build}, but this is build {this}");
    let remedy = "merge with that build, or run the shard again with this one in another folder";
    Fault::data(message).in_file(path).with_remedy(remedy)
}

fn expect_campaign(fault: Fault) -> Fault {
    fault.with_remedy("expected the folder of a campaign or of a shard")
}
