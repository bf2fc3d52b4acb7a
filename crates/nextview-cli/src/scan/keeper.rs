use super::ScanConfig;
use crate::{Failure, files};
use nextview::sensor::Frame;
use nextview::session::NextView;
use nextview_recording::{Damage, Journal, Kept, KeptFrame};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// The frames of a scan on the disk, so that the scan can go on after it was interrupted.
pub(super) struct FrameKeeper {
    dir: PathBuf,
    /// The topmost folder that was not there before the scan.
    created: Option<PathBuf>,
    journal: Journal,
    /// Those of before the interruption that the scan has not come to again.
    kept: VecDeque<KeptFrame>,
    n_taken: usize,
    /// Number of frames that would be lost with the journal.
    n_needed: usize,
}

/// A scan that was interrupted.
pub(super) struct Interrupted {
    /// As it was begun.
    pub config: ScanConfig,
    pub keeper: FrameKeeper,
    /// What there is to tell, a line each.
    pub notes: Vec<String>,
}

/// Name of the journal in the folder of results.
const NAME: &str = "scan.journal";

impl Interrupted {
    /// Finds out how far the scan in this folder came.
    pub fn open(dir: &Path) -> Result<Self, Failure> {
        let path = dir.join(NAME);
        if !path.exists() {
            let problem = "holds no interrupted scan: there is no scan.journal, which a scan begins and, once it is finished, removes";
            return Err(Failure::data(problem).in_file(dir));
        }
        let (journal, Kept { heading, frames, damage }) = Journal::open(&path)?;
        let table = heading.parse::<toml::Table>().map_err(|error| Failure::data(error).in_file(&path))?;
        let config = ScanConfig::from_table(table).map_err(|failure| failure.in_file(&path))?;
        files::remove_unfinished(dir).map_err(|e| Failure::from(e).while_writing(dir))?;
        let n = frames.len();
        let notes = [
            damage.map(|damage| damage_note(&path, &damage)),
            Some(format!("note: goes on after {}", n_frames(n))),
        ];
        let keeper = FrameKeeper::new(dir, None, journal, frames);
        Ok(Self { config, keeper, notes: notes.into_iter().flatten().collect() })
    }
}

impl FrameKeeper {
    /// Fails if the folder holds an interrupted scan, which would be lost.
    pub fn check_free(dir: &Path) -> Result<(), Failure> {
        let path = dir.join(NAME);
        if !path.exists() {
            return Ok(());
        }
        let hint = format!(
            "--resume {0} goes on with it; pass another --out, or remove {1}",
            dir.display(),
            path.display()
        );
        Err(Failure::data("holds an interrupted scan").in_file(dir).with_hint(hint))
    }

    /// Begins a scan in a folder that is free.
    pub fn begin(config: &ScanConfig, dir: &Path) -> Result<Self, Failure> {
        let heading = toml::to_string(config).map_err(Failure::data)?;
        let created = dir.ancestors().take_while(|dir| !dir.exists()).last().map(Path::to_owned);
        std::fs::create_dir_all(dir).map_err(|e| Failure::from(e).while_writing(dir))?;
        let journal = Journal::create(&dir.join(NAME), &heading)?;
        Ok(Self::new(dir, created, journal, Vec::new()))
    }

    fn new(dir: &Path, created: Option<PathBuf>, journal: Journal, kept: Vec<KeptFrame>) -> Self {
        let n_needed = kept.len();
        Self { dir: dir.to_owned(), created, journal, kept: kept.into(), n_taken: 0, n_needed }
    }

    /// The frame as it counts: that of the journal where the scan was there before, or else this one, once it is on the disk.
    pub fn keep(&mut self, next: &NextView, frame: Frame) -> Result<Frame, Failure> {
        self.n_taken += 1;
        let Some(kept) = self.kept.pop_front() else {
            self.journal.keep(next.view, &frame).map_err(|error| self.not_kept(error.into()))?;
            self.n_needed += 1;
            return Ok(frame);
        };
        if kept.view == next.view {
            return Ok(kept.frame);
        }
        let name =
            |view: Option<usize>| view.map_or("no candidate".to_owned(), |view| format!("view {view}"));
        let problem = format!(
            "frame {} is of {}, but the planner now chooses {}",
            self.n_taken,
            name(kept.view),
            name(next.view)
        );
        Err(Failure::data(problem)
            .in_file(&self.dir.join(NAME))
            .with_hint("a scan goes on only with the version of nextview and the files it was begun with"))
    }

    /// The results are on the disk, or there will be none: the frames are needed no longer.
    pub fn finish(mut self) {
        self.n_needed = 0;
    }

    fn not_kept(&self, failure: Failure) -> Failure {
        let hint = match self.n_needed {
            0 => "is the disk full?".to_owned(),
            n => format!("is the disk full? --resume {} goes on after {}", self.dir.display(), n_frames(n)),
        };
        failure.with_hint(hint)
    }
}

impl Drop for FrameKeeper {
    /// Without frames the journal is of no use, nor is a folder that holds nothing else.
    fn drop(&mut self) {
        if self.n_needed > 0 {
            return;
        }
        let _ = std::fs::remove_file(self.dir.join(NAME));
        let Some(topmost) = &self.created else { return };
        let empty = self.dir.ancestors().take_while(|dir| dir.starts_with(topmost));
        empty.for_each(|dir| _ = std::fs::remove_dir(dir));
    }
}

fn n_frames(n: usize) -> String {
    format!("{n} frame{}", if n == 1 { "" } else { "s" })
}

fn damage_note(path: &Path, damage: &Damage) -> String {
    let Damage { at, length, problem, moved_to } = damage;
    let (path, moved_to) = (path.display(), moved_to.display());
    format!("note: {path}: damaged from byte {at} on ({problem}); these {length} bytes are now in {moved_to}")
}
