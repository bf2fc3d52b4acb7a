use super::RUNS;
use super::checks::{check_build, check_config, check_same};
use super::known_runs::{KnownRuns, conflict};
use super::records::{Records, in_line};
use crate::{Run, RunId, RunRecord, Spec, tables};
use nextview_scan::files::{self, Overwrite};
use nextview_scan::{Fault, Faults};
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};

/// A campaign's folder that this process alone writes to, however many threads it has.
#[derive(Debug)]
pub struct Store {
    dir: PathBuf,
    /// Locked as long as it is open.
    file: File,
    n_objects: usize,
    runs: Vec<Run>,
    /// Beside `runs`.
    records: Vec<Option<RunRecord>>,
    numbers: BTreeMap<RunId, usize>,
    was_torn: bool,
    /// After a failed write the end of the file is not known to be whole.
    is_damaged: bool,
}

impl Store {
    /// Opens the folder for this specification: a new one, or, if it may be resumed, one of the very same
    /// specification. A new one may hold other files, but none that the campaign would replace.
    pub fn open(dir: &Path, spec: &Spec, resume: bool) -> Result<Self, Faults> {
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
            return Err(Fault::data("is no regular file").in_file(&path).into());
        }
        lock(&file).map_err(|fault| fault.in_file(dir))?;
        let has_runs = file.metadata().map_err(writing)?.len() > 0;
        if has_runs && !resume {
            let fault = Fault::data("has the results of a campaign already").in_file(dir);
            return Err(fault.with_remedy("resume it (`resume`), or choose another folder (`out`)").into());
        }
        if !saved.exists() {
            let missing = || Fault::data("is missing, expected that of runs.jsonl").in_file(&saved);
            let text = if has_runs { Err(missing()) } else { spec.to_toml() }?;
            files::write(&saved, &Overwrite::nothing(), |w| Ok(w.write_all(text.as_bytes())?))?;
        }
        let numbers = runs.iter().map(|run| run.id.clone()).zip(0..).collect();
        let (records, n_objects) = (vec![None; runs.len()], spec.objects.len());
        let (was_torn, is_damaged) = (false, false);
        let dir = dir.to_owned();
        let mut store = Self { dir, file, n_objects, runs, records, numbers, was_torn, is_damaged };
        store.load()?;
        Ok(store)
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Number of objects of the campaign.
    pub fn n_objects(&self) -> usize {
        self.n_objects
    }

    /// All runs of the campaign, in the order of [`Spec::runs`].
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The record of each of [`Store::runs`]; none of those that are open.
    pub fn records(&self) -> &[Option<RunRecord>] {
        &self.records
    }

    /// The records that there are, in the order of the runs.
    pub fn finished(&self) -> Vec<&RunRecord> {
        self.records.iter().flatten().collect()
    }

    /// Whether the last line was not whole when the folder was opened, and was cut.
    pub fn was_torn(&self) -> bool {
        self.was_torn
    }

    /// Adds the record of a run: on the disk, whole, when this returns. One that equals that of the same run
    /// changes nothing.
    pub fn append(&mut self, record: &RunRecord) -> Result<(), Fault> {
        let path = self.dir.join(RUNS);
        if self.is_damaged {
            return Err(Fault::data("an earlier write failed").while_writing(&path));
        }
        let number = self.number(record).map_err(|fault| fault.in_file(&path))?;
        if let Some(known) = &self.records[number] {
            return conflict(known, record).map_or(Ok(()), |difference| {
                let message = format!("another record of {} is there: {difference}", record.id());
                Err(Fault::data(message).in_file(&path))
            });
        }
        let line = serde_json::to_string(record).map_err(Fault::data)? + "\n";
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|e| {
            self.is_damaged = true;
            Fault::from(e)
                .while_writing(&path)
                .with_remedy("resume the campaign once the file can be written")
        })?;
        self.records[number] = Some(record.clone());
        Ok(())
    }

    /// Reads the records that are there, and cuts a last line that is not whole.
    fn load(&mut self) -> Result<(), Faults> {
        let path = self.dir.join(RUNS);
        let mut known = KnownRuns::default();
        let mut records = Records::new(BufReader::new(self.file.try_clone()?), &path);
        for stored in records.by_ref() {
            let stored = stored?;
            let line = stored.line;
            let checked = self.number(&stored.record).and_then(|_| known.add(stored));
            checked.map_err(|fault| in_line(fault, line, &path))?;
        }
        for record in known.into_records() {
            let number = self.numbers[&record.id()];
            self.records[number] = Some(record);
        }
        if records.is_torn() {
            self.was_torn = true;
            let cut = self.file.set_len(records.n_bytes()).and_then(|()| self.file.sync_all());
            cut.map_err(|e| Fault::from(e).while_writing(&path))?;
        }
        Ok(())
    }

    /// The number of the run that this is the record of; fails if it is none of this campaign and build.
    fn number(&self, record: &RunRecord) -> Result<usize, Fault> {
        check_build(record)?;
        let id = record.id();
        let number = self.numbers.get(&id).copied();
        let number = number.ok_or_else(|| Fault::data(format!("no run of this campaign: {id}")))?;
        check_config(&self.runs[number], record).map(|()| number)
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
