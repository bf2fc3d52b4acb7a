//! The folder of a campaign: the specification, a line per run, and one writer at a time.

use super::RunRecord;
use super::campaign::{Run, RunId};
use super::spec::Spec;
use crate::{Failure, files};
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The specification, with whole paths.
pub(super) const SPEC: &str = "spec.toml";

/// The truth about the runs: a [`RunRecord`] a line, in the order in which they ended.
const RUNS: &str = "runs.jsonl";

/// A folder that this process alone writes to: the lock on [`RUNS`] ends with the process, however it ends.
pub(super) struct Folder {
    pub dir: PathBuf,
    runs: File,
    /// After a failed write the end of the file is not known to be whole.
    is_damaged: bool,
}

impl Folder {
    /// Opens the folder for this specification, new or, if asked for, one with results of the very same.
    pub fn open(dir: &Path, spec: &Spec, resume: bool) -> Result<Self, Failure> {
        let writing = |e: std::io::Error| Failure::from(e).while_writing(dir);
        fs::create_dir_all(dir).map_err(writing)?;
        let path = dir.join(RUNS);
        let runs = File::options().read(true).append(true).create(true).open(&path).map_err(writing)?;
        lock(&runs).map_err(|failure| failure.in_file(dir))?;
        let has_runs = runs.metadata().map_err(writing)?.len() > 0;
        if has_runs && !resume {
            let failure = Failure::data("has the results of a campaign already").in_file(dir);
            return Err(failure.with_hint("pass --resume to go on with it, or another --out"));
        }
        let saved = dir.join(SPEC);
        if has_runs || (resume && saved.exists()) {
            check_same(&Spec::reload(&saved)?, spec).map_err(|failure| failure.in_file(&saved))?;
        } else {
            let text = toml::to_string(spec).map_err(Failure::data)?;
            files::write(&saved, |w| Ok(w.write_all(text.as_bytes())?))?;
        }
        Ok(Self { dir: dir.to_owned(), runs, is_damaged: false })
    }

    /// What is known of each run; none if it is still to do. A last line that was cut short is removed.
    pub fn records(&mut self, runs: &[Run]) -> Result<Vec<Option<RunRecord>>, Failure> {
        let path = self.dir.join(RUNS);
        let text = fs::read(&path).map_err(|e| Failure::from(e).in_file(&path))?;
        let numbers: BTreeMap<&RunId, usize> = runs.iter().map(|run| &run.id).zip(0..).collect();
        let mut records = vec![None; runs.len()];
        let mut begin = 0;
        for (line, number) in text.split_inclusive(|&byte| byte == b'\n').zip(1..) {
            let end = begin + line.len();
            let (is_last, is_cut) = (end == text.len(), line.last() != Some(&b'\n'));
            let record = serde_json::from_slice::<RunRecord>(line);
            if is_cut || (is_last && record.is_err()) {
                self.cut(begin).map_err(|e| Failure::from(e).while_writing(&path))?;
                break;
            }
            record
                .map_err(Failure::data)
                .and_then(|record| place(record, runs, &numbers, &mut records))
                .map_err(|failure| failure.within(format!("line {number}")).in_file(&path))?;
            begin = end;
        }
        Ok(records)
    }

    /// Adds a run: on the disk, whole, when this returns.
    pub fn append(&mut self, record: &RunRecord) -> Result<(), Failure> {
        let path = self.dir.join(RUNS);
        if self.is_damaged {
            return Err(Failure::data("an earlier write failed").while_writing(&path));
        }
        let line = serde_json::to_string(record).map_err(Failure::data)? + "\n";
        let written = self.runs.write_all(line.as_bytes()).and_then(|()| self.runs.sync_data());
        written.map_err(|e| {
            self.is_damaged = true;
            Failure::from(e).while_writing(&path).with_hint("go on with --resume once it can be written")
        })
    }

    fn cut(&mut self, len: usize) -> std::io::Result<()> {
        eprintln!("note: the last line of {RUNS} is not whole; its run is done again");
        self.runs.set_len(len as u64)?;
        self.runs.sync_all()
    }
}

fn lock(file: &File) -> Result<(), Failure> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(Failure::data("another process is writing there")
            .with_hint("wait for its end, or pass another --out")),
        Err(TryLockError::Error(e)) => Err(Failure::data(format!("cannot be locked: {e}"))),
    }
}

/// Puts a record where its run is; fails if it is none of this campaign.
fn place(
    record: RunRecord,
    runs: &[Run],
    numbers: &BTreeMap<&RunId, usize>,
    records: &mut [Option<RunRecord>],
) -> Result<(), Failure> {
    let id = RunId::of(&record);
    let number = *numbers.get(&id).ok_or_else(|| Failure::data(format!("no run of this campaign: {id}")))?;
    if records[number].is_some() {
        return Err(Failure::data(format!("a second result of one run: {id}")));
    }
    // The voxel size may have been chosen in the run, to suit the object.
    let mut expected = runs[number].config.clone();
    expected.voxel_size_m = expected.voxel_size_m.or(record.config.voxel_size_m);
    let [expected, found] = [&expected, &record.config].map(toml::Table::try_from);
    let difference = difference(&expected.map_err(Failure::data)?, &found.map_err(Failure::data)?, "");
    if let Some(difference) = difference {
        let message = format!("{id}: its configuration is not that of this program: {difference}");
        return Err(Failure::data(message).with_hint("begin anew in another --out"));
    }
    records[number] = Some(record);
    Ok(())
}

fn check_same(saved: &Spec, given: &Spec) -> Result<(), Failure> {
    let [saved, given] = [saved, given].map(|spec| toml::Table::try_from(spec).map_err(Failure::data));
    match difference(&given?, &saved?, "") {
        Some(difference) => {
            Err(Failure::data(format!("the folder is that of another specification: {difference}"))
                .with_hint(
                    "pass another --out, or --resume and --out alone to go on with the one in the folder",
                ))
        }
        None => Ok(()),
    }
}

/// The first difference between two tables, in words.
fn difference(expected: &toml::Table, found: &toml::Table, prefix: &str) -> Option<String> {
    let keys: std::collections::BTreeSet<&String> = expected.keys().chain(found.keys()).collect();
    keys.into_iter().find_map(|key| {
        let path = format!("{prefix}{key}");
        match (expected.get(key), found.get(key)) {
            (expected, found) if expected == found => None,
            (Some(toml::Value::Table(expected)), Some(toml::Value::Table(found))) => {
                difference(expected, found, &format!("{path}."))
            }
            (expected, found) => {
                let [expected, found] =
                    [expected, found].map(|value| value.map_or("not set".to_owned(), toml::Value::to_string));
                Some(format!("{path} is {found} there, {expected} here"))
            }
        }
    })
}
