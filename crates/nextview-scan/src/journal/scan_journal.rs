use super::file::{Damage, Journal, Kept};
use super::kept::{JournalEntry, KeptFrame, SkippedView};
use crate::files::{self, PathTarget};
use crate::{Fault, Faults};
use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};

/// The journal in the folder of a scan's results, from the first frame until the results are on the disk.
pub struct ScanJournal {
    dir: PathBuf,
    /// The topmost folder created for the scan.
    created: Option<PathBuf>,
    journal: Journal,
    /// Entries from before the interruption that the scan has not yet replayed.
    replays: VecDeque<JournalEntry>,
    /// Number of frames that would be lost with the journal.
    n_needed: usize,
}

/// The occupant of a folder of results.
pub(crate) enum Occupant {
    /// Nobody: the journal of a scan killed before its first frame is useless.
    Nobody,
    /// A scan in progress, in this process or another one.
    Scan,
    /// An interrupted scan, with its frames.
    Interrupted,
}

/// An interrupted scan.
pub struct Interrupted {
    /// The text at the beginning of the journal: the configuration.
    pub heading: String,
    /// The journal, to resume the scan.
    pub journal: ScanJournal,
    /// Number of kept frames.
    pub n_frames: usize,
    /// Damage found at the end of the journal.
    pub damage: Option<Damage>,
}

impl ScanJournal {
    /// Name of the file in the folder of results.
    pub const FILE: &str = "scan.journal";

    /// Whether the folder holds an interrupted scan.
    pub fn is_in(dir: &Path) -> bool {
        dir.join(Self::FILE).exists()
    }

    /// Begins the journal of a scan. Fails if the folder holds an interrupted scan, which would be lost, or a
    /// scan in progress: no other scan can begin there until the journal is dropped.
    pub fn begin(dir: &Path, heading: &str) -> Result<Self, Fault> {
        Self::check_free(dir)?;
        let path = dir.join(Self::FILE);
        Self::remove_bare(&path);
        let writing = |error: io::Error| Fault::from(error).while_writing(dir);
        let place = std::path::absolute(&path).map_err(writing)?;
        let created = files::create_folder(place.parent().unwrap_or(&place)).map_err(writing)?;
        // Another scan may have begun there in the meantime.
        let journal =
            Journal::create(&path, heading).map_err(|fault| Self::check_free(dir).err().unwrap_or(fault))?;
        files::remove_unfinished(dir, &[Self::FILE]).map_err(writing)?;
        Ok(Self { dir: dir.to_owned(), created, journal, replays: VecDeque::new(), n_needed: 0 })
    }

    /// Removes the journal of a scan killed before its first frame.
    fn remove_bare(path: &Path) {
        if !Journal::is_bare(path) {
            return;
        }
        // Once it is open here, nobody else can write to it. If opening fails, it is in use.
        if let Ok((_journal, kept)) = Journal::open(path)
            && kept.entries.is_empty()
        {
            _ = std::fs::remove_file(path);
        }
    }

    /// Fails if the folder holds an interrupted scan or a scan in progress.
    pub fn check_free(dir: &Path) -> Result<(), Fault> {
        match Self::occupant(dir) {
            Occupant::Nobody => Ok(()),
            Occupant::Scan => Err(being_scanned(dir)),
            Occupant::Interrupted => {
                let (name, path) = (dir.display(), dir.join(Self::FILE));
                let other = format!("choose another folder (`out`), or remove {}", path.display());
                let fault = Fault::data("holds an interrupted scan").in_file(dir);
                Err(fault.with_remedy(format!("`resume` = {name} resumes it; {other}")))
            }
        }
    }

    /// The occupant of the folder.
    pub(crate) fn occupant(dir: &Path) -> Occupant {
        let path = dir.join(Self::FILE);
        match () {
            () if !path.exists() => Occupant::Nobody,
            () if Journal::is_open(&path) => Occupant::Scan,
            () if Journal::is_bare(&path) => Occupant::Nobody,
            () => Occupant::Interrupted,
        }
    }

    /// Opens the journal of an interrupted scan.
    pub fn resume(dir: &Path) -> Result<Interrupted, Faults> {
        if !Self::is_in(dir) {
            return Err(nothing_to_resume(dir).into());
        }
        let (journal, Kept { heading, entries, damage }) =
            Journal::open(&dir.join(Self::FILE)).map_err(|fault| match Self::occupant(dir) {
                Occupant::Scan => being_scanned(dir),
                // Another process has finished the scan meanwhile.
                _ if !Self::is_in(dir) => nothing_to_resume(dir),
                _ => fault,
            })?;
        let name = dir.file_name().unwrap_or_default().to_string_lossy();
        files::remove_unfinished(dir, &[&name, Self::FILE]).map_err(|e| Fault::from(e).while_writing(dir))?;
        let n_frames = entries.iter().filter(|entry| matches!(entry, JournalEntry::Frame(_))).count();
        let journal =
            Self { dir: dir.to_owned(), created: None, journal, replays: entries.into(), n_needed: n_frames };
        Ok(Interrupted { heading, journal, n_frames, damage })
    }

    /// The next entry from before the interruption that the scan has not yet replayed.
    pub(crate) fn replay(&self) -> Option<&JournalEntry> {
        self.replays.front()
    }

    /// Marks that entry as replayed.
    pub(crate) fn replayed(&mut self) {
        self.replays.pop_front();
    }

    /// Replays this kept frame again.
    pub(crate) fn replay_again(&mut self, kept: KeptFrame) {
        self.replays.push_front(JournalEntry::Frame(Box::new(kept)));
    }

    /// Keeps a frame: it is on the disk on return.
    pub(crate) fn keep(&mut self, kept: &KeptFrame) -> Result<(), Fault> {
        self.journal.keep(kept).map_err(|fault| self.not_kept(fault))?;
        self.n_needed += 1;
        Ok(())
    }

    /// Keeps a skipped view.
    pub(crate) fn skip(&mut self, skipped: &SkippedView) -> Result<(), Fault> {
        self.journal.skip(skipped).map_err(|fault| self.not_kept(fault))
    }

    /// Fails if the kept frames are no longer where they should be.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.journal.check()
    }

    /// Fails if the folder belongs to another scan or has moved. If the journal is gone, the results are all
    /// that is left of the scan, and may be written.
    pub(crate) fn check_results(&self) -> Result<(), Fault> {
        match self.journal.path_target() {
            Ok(PathTarget::Removed) => Ok(()),
            _ => self.journal.check(),
        }
    }

    /// The path of the file.
    pub(crate) fn path(&self) -> PathBuf {
        self.dir.join(Self::FILE)
    }

    /// Removes the journal: the results are on the disk, or there will be none.
    pub fn finish(mut self) {
        self.n_needed = 0;
    }

    fn not_kept(&self, fault: Fault) -> Fault {
        if !matches!(self.journal.path_target(), Ok(PathTarget::There)) {
            return fault;
        }
        let (dir, remedy) = (self.dir.display(), fault.remedy.clone().unwrap_or_default());
        fault.with_remedy(match self.n_needed {
            0 => remedy,
            1 => format!("{remedy} `resume` = {dir} resumes the scan after 1 frame"),
            n => format!("{remedy} `resume` = {dir} resumes the scan after {n} frames"),
        })
    }
}

impl Drop for ScanJournal {
    /// Removes a journal without frames, and a folder that contains nothing else, unless it belongs to
    /// another scan.
    fn drop(&mut self) {
        if self.n_needed > 0 || self.journal.check().is_err() {
            return;
        }
        let place = self.journal.place();
        let _ = std::fs::remove_file(place);
        let Some(topmost) = &self.created else { return };
        let empty = place.ancestors().skip(1).take_while(|dir| dir.starts_with(topmost));
        empty.for_each(|dir| _ = std::fs::remove_dir(dir));
    }
}

fn being_scanned(dir: &Path) -> Fault {
    let fault = Fault::data("is in use by a running scan, here or in another process").in_file(dir);
    fault.with_remedy("choose another folder (`out`), or wait until that scan is finished")
}

fn nothing_to_resume(dir: &Path) -> Fault {
    let message = "holds no interrupted scan: there is no scan.journal, which a scan creates and removes when it is \
                   finished";
    Fault::data(message).in_file(dir)
}
