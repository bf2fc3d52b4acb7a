use super::RUNS;
use super::checks::{check_build, check_config, check_same};
use super::conflict::{check_repeated, conflict};
use super::records::{Position, Records, in_line};
use super::run_records::{RunRecords, read_at};
use crate::failed_runs::FailureCounts;
use crate::{FailedRuns, RunRecord, Runs, Shard, Spec, tables};
use nextview_scan::files::{self, Overwrite};
use nextview_scan::{Fault, Faults};
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};
use std::slice;

/// A campaign's folder to which only this process writes, with any number of threads. Records stay on disk.
#[derive(Debug)]
pub struct Store {
    dir: PathBuf,
    path: PathBuf,
    /// Locked while it is open.
    file: File,
    /// Size of the file, bytes.
    n_bytes: u64,
    n_lines: usize,
    runs: Runs,
    /// The runs to execute here, by their common object.
    share: Vec<Vec<usize>>,
    /// For each run of the campaign, the place of its record.
    positions: Vec<Option<Position>>,
    failures: FailureCounts,
    was_torn: bool,
    /// Whether a write failed: the end of the file may be incomplete.
    is_damaged: bool,
}

impl Store {
    /// Opens the folder for this specification: a new one or, if `resume`, one with the same specification. A
    /// new folder may hold other files, but none that the campaign would replace. The runs of the shard are
    /// to be executed here; the folder may hold records of others, too.
    pub fn open(dir: &Path, spec: &Spec, shard: Shard, resume: bool) -> Result<Self, Faults> {
        let runs = spec.runs()?;
        let (path, saved) = (dir.join(RUNS), dir.join(Spec::FILE));
        if !resume && !path.exists() {
            let remedy = "choose another folder (`out`)";
            let checked = Overwrite::nothing().check_folder(dir, tables::FILES);
            checked.map_err(|faults| faults.map(|fault| fault.with_remedy(remedy)))?;
        }
        if saved.exists() {
            check_same(&Spec::of_folder(dir)?, spec).map_err(|fault| fault.in_file(&saved))?;
        }
        let writing = |e: io::Error| Fault::from(e).while_writing(dir);
        fs::create_dir_all(dir).map_err(writing)?;
        let file = File::options().read(true).append(true).create(true).open(&path).map_err(writing)?;
        if !file.metadata().map_err(writing)?.is_file() {
            return Err(Fault::data("is not a regular file").in_file(&path).into());
        }
        lock(&file).map_err(|fault| fault.in_file(dir))?;
        files::remove_unfinished(dir, &[tables::FILES, &[Spec::FILE]].concat()).map_err(writing)?;
        let has_runs = file.metadata().map_err(writing)?.len() > 0;
        if has_runs && !resume {
            let fault = Fault::data("already has the results of a campaign").in_file(dir);
            return Err(fault.with_remedy("resume it (`resume`), or choose another folder (`out`)").into());
        }
        if !saved.exists() {
            let missing =
                || Fault::data("is missing, expected the specification of runs.jsonl").in_file(&saved);
            let text = if has_runs { Err(missing()) } else { spec.to_toml() }?;
            files::write(&saved, &Overwrite::nothing(), |w| Ok(w.write_all(text.as_bytes())?))?;
        }
        let mut store = Self {
            dir: dir.to_owned(),
            path,
            file,
            n_bytes: 0,
            n_lines: 0,
            share: shard.groups(&runs),
            positions: vec![None; runs.len()],
            runs,
            failures: FailureCounts::default(),
            was_torn: false,
            is_damaged: false,
        };
        store.load()?;
        Ok(store)
    }

    /// Returns the folder of the campaign.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Returns all runs of the campaign.
    pub fn runs(&self) -> &Runs {
        &self.runs
    }

    /// Returns the runs to execute here, by their numbers; those of a group have a common object.
    pub fn share(&self) -> &[Vec<usize>] {
        &self.share
    }

    /// Runs of the share without a record.
    pub(crate) fn open_groups(&self) -> Vec<Vec<usize>> {
        let is_open = |number: &usize| !self.is_finished(*number);
        let open = |group: &Vec<usize>| group.iter().copied().filter(is_open).collect();
        self.share.iter().map(open).filter(|group: &Vec<usize>| !group.is_empty()).collect()
    }

    /// Returns whether the run with this number has a record.
    pub fn is_finished(&self, number: usize) -> bool {
        self.positions.get(number).is_some_and(Option::is_some)
    }

    /// Returns the existing records, in the order of the runs.
    pub fn finished(&self) -> RunRecords {
        RunRecords::new(vec![self.path.clone()], self.positions.iter().flatten().copied().collect())
    }

    /// Returns the failed runs, by object and reason.
    pub fn failed(&self) -> Vec<FailedRuns> {
        self.failures.list()
    }

    /// Returns whether the last line was incomplete when the folder was opened, and was cut.
    pub fn was_torn(&self) -> bool {
        self.was_torn
    }

    /// Adds the record of a run: complete and on disk when this returns. A record equal to that of the same
    /// run changes nothing.
    pub fn append(&mut self, record: &RunRecord) -> Result<(), Fault> {
        if self.is_damaged {
            return Err(Fault::data("an earlier write failed").while_writing(&self.path));
        }
        let number = self.number(record).map_err(|fault| fault.in_file(&self.path))?;
        if let Some(known) = self.positions[number] {
            let known = read_at(slice::from_ref(&self.path), known)?;
            return conflict(&known, record).map_or(Ok(()), |difference| {
                let message = format!("there is already a different record of {}: {difference}", record.id());
                Err(Fault::data(message).in_file(&self.path))
            });
        }
        let line = serde_json::to_string(record).map_err(Fault::data)? + "\n";
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|e| {
            self.is_damaged = true;
            Fault::from(e)
                .while_writing(&self.path)
                .with_remedy("resume the campaign once the file can be written")
        })?;
        self.n_lines += 1;
        let (line_number, offset) = (self.n_lines, self.n_bytes);
        let n_bytes = line.len() as u32 - 1;
        self.positions[number] = Some(Position { file: 0, line: line_number, offset, n_bytes });
        self.n_bytes += line.len() as u64;
        self.failures.add(record);
        Ok(())
    }

    /// Reads the existing records, and cuts an incomplete last line.
    fn load(&mut self) -> Result<(), Faults> {
        let mut records = Records::new(BufReader::new(self.file.try_clone()?), &self.path);
        for stored in records.by_ref() {
            let stored = stored?;
            let line = stored.line;
            self.n_lines = line;
            let checked = self.number(&stored.record).and_then(|number| match self.positions[number] {
                Some(known) => check_repeated(slice::from_ref(&self.path), known, &stored),
                None => {
                    self.positions[number] = Some(stored.position);
                    self.failures.add(&stored.record);
                    Ok(())
                }
            });
            checked.map_err(|fault| in_line(fault, line, &self.path))?;
        }
        self.n_bytes = records.n_bytes();
        if records.is_torn() {
            self.was_torn = true;
            let cut = self.file.set_len(records.n_bytes()).and_then(|()| self.file.sync_all());
            cut.map_err(|e| Fault::from(e).while_writing(&self.path))?;
        }
        Ok(())
    }

    /// The number of this record's run; fails if it is not of this campaign and build.
    fn number(&self, record: &RunRecord) -> Result<usize, Fault> {
        check_build(record)?;
        let id = record.id();
        let missing = || Fault::data(format!("no run of this campaign: {id}"));
        let number = self.runs.number(&id).ok_or_else(missing)?;
        let run = self.runs.get(number).ok_or_else(missing)?;
        check_config(&run, record).map(|()| number)
    }
}

fn lock(file: &File) -> Result<(), Fault> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(Fault::data("another process is writing there")
            .with_remedy("wait until it ends, or choose another folder (`out`)")),
        Err(TryLockError::Error(e)) => Err(Fault::data(format!("cannot be locked: {e}"))),
    }
}
