use super::file::{Damage, Journal, Kept};
use super::kept::{JournalEntry, KeptFrame, SkippedView};
use crate::{Fault, Faults, files};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// The journal in the folder of a scan's results, from the first frame until the results are on the disk.
pub struct ScanJournal {
    dir: PathBuf,
    /// The topmost folder that was not there before the scan.
    created: Option<PathBuf>,
    journal: Journal,
    /// Entries from before the interruption that the scan has not reached again.
    replays: VecDeque<JournalEntry>,
    /// Number of frames that would be lost with the journal.
    n_needed: usize,
}

/// A scan that was interrupted.
pub struct Interrupted {
    /// The text that the journal was begun with: the configuration.
    pub heading: String,
    /// To resume it.
    pub journal: ScanJournal,
    /// Number of frames that are kept.
    pub n_frames: usize,
    /// Damage that was found at the journal's end.
    pub damage: Option<Damage>,
}

impl ScanJournal {
    /// Name of the file in the folder of results.
    pub const FILE: &str = "scan.journal";

    /// Whether the folder holds an interrupted scan.
    pub fn is_in(dir: &Path) -> bool {
        dir.join(Self::FILE).exists()
    }

    /// Begins the journal of a scan; fails if the folder holds an interrupted one, which would be lost.
    pub fn begin(dir: &Path, heading: &str) -> Result<Self, Fault> {
        Self::check_free(dir)?;
        let created = dir.ancestors().take_while(|dir| !dir.exists()).last().map(Path::to_owned);
        std::fs::create_dir_all(dir).map_err(|e| Fault::from(e).while_writing(dir))?;
        let journal = Journal::create(&dir.join(Self::FILE), heading)?;
        Ok(Self { dir: dir.to_owned(), created, journal, replays: VecDeque::new(), n_needed: 0 })
    }

    /// Fails if the folder holds an interrupted scan.
    pub fn check_free(dir: &Path) -> Result<(), Fault> {
        if !Self::is_in(dir) {
            return Ok(());
        }
        let path = dir.join(Self::FILE);
        let (dir_name, path) = (dir.display(), path.display());
        let remedy =
            format!("`resume` = {dir_name} resumes it; choose another folder (`out`), or remove {path}");
        Err(Fault::data("holds an interrupted scan").in_file(dir).with_remedy(remedy))
    }

    /// Opens the journal of an interrupted scan.
    pub fn resume(dir: &Path) -> Result<Interrupted, Faults> {
        if !Self::is_in(dir) {
            let message = "holds no interrupted scan: there is no scan.journal, which a scan creates and removes \
                           when it is finished";
            return Err(Fault::data(message).in_file(dir).into());
        }
        let (journal, Kept { heading, entries, damage }) = Journal::open(&dir.join(Self::FILE))?;
        let name = dir.file_name().unwrap_or_default().to_string_lossy();
        files::remove_unfinished(dir, &[&name]).map_err(|e| Fault::from(e).while_writing(dir))?;
        let n_frames = entries.iter().filter(|entry| matches!(entry, JournalEntry::Frame(_))).count();
        let journal =
            Self { dir: dir.to_owned(), created: None, journal, replays: entries.into(), n_needed: n_frames };
        Ok(Interrupted { heading, journal, n_frames, damage })
    }

    /// The next entry from before the interruption that the scan has not reached again.
    pub(crate) fn replay(&self) -> Option<&JournalEntry> {
        self.replays.front()
    }

    /// The scan has reached that entry.
    pub(crate) fn replayed(&mut self) {
        self.replays.pop_front();
    }

    /// The scan comes to this frame, which is kept, again.
    pub(crate) fn replay_again(&mut self, kept: KeptFrame) {
        self.replays.push_front(JournalEntry::Frame(Box::new(kept)));
    }

    /// Keeps a frame: on the disk when this returns.
    pub(crate) fn keep(&mut self, kept: &KeptFrame) -> Result<(), Fault> {
        self.journal.keep(kept).map_err(|fault| self.not_kept(fault))?;
        self.n_needed += 1;
        Ok(())
    }

    /// Keeps that a view is not to be proposed again.
    pub(crate) fn skip(&mut self, skipped: &SkippedView) -> Result<(), Fault> {
        self.journal.skip(skipped).map_err(|fault| self.not_kept(fault))
    }

    /// The path of the file.
    pub(crate) fn path(&self) -> PathBuf {
        self.dir.join(Self::FILE)
    }

    /// The results are on the disk, or there will be none: the journal is removed.
    pub fn finish(mut self) {
        self.n_needed = 0;
    }

    fn not_kept(&self, fault: Fault) -> Fault {
        let dir = self.dir.display();
        fault.with_remedy(match self.n_needed {
            0 => "is the disk full?".to_owned(),
            1 => format!("is the disk full? `resume` = {dir} resumes the scan after 1 frame"),
            n => format!("is the disk full? `resume` = {dir} resumes the scan after {n} frames"),
        })
    }
}

impl Drop for ScanJournal {
    /// Without frames the journal is of no use, nor is a folder that holds nothing else.
    fn drop(&mut self) {
        if self.n_needed > 0 {
            return;
        }
        let _ = std::fs::remove_file(self.path());
        let Some(topmost) = &self.created else { return };
        let empty = self.dir.ancestors().take_while(|dir| dir.starts_with(topmost));
        empty.for_each(|dir| _ = std::fs::remove_dir(dir));
    }
}
