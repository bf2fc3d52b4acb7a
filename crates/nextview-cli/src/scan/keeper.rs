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
    journal: Journal,
    /// Those of before the interruption that the scan has not come to again.
    kept: VecDeque<KeptFrame>,
    n_taken: usize,
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
        let keeper = FrameKeeper { dir: dir.to_owned(), journal, kept: frames.into(), n_taken: 0 };
        Ok(Self { config, keeper, notes: notes.into_iter().flatten().collect() })
    }
}

impl FrameKeeper {
    /// Begins a scan; fails if the folder holds an interrupted one, which would be lost.
    pub fn begin(config: &ScanConfig, dir: &Path) -> Result<Self, Failure> {
        let path = dir.join(NAME);
        if path.exists() {
            let problem = "holds an interrupted scan";
            let hint = format!(
                "--resume {0} goes on with it; pass another --out, or remove {1}",
                dir.display(),
                path.display()
            );
            return Err(Failure::data(problem).in_file(dir).with_hint(hint));
        }
        let heading = toml::to_string(config).map_err(Failure::data)?;
        std::fs::create_dir_all(dir).map_err(|e| Failure::from(e).while_writing(dir))?;
        let journal = Journal::create(&path, &heading)?;
        Ok(Self { dir: dir.to_owned(), journal, kept: VecDeque::new(), n_taken: 0 })
    }

    /// The frame as it counts: that of the journal where the scan was there before, or else this one, once it is on the disk.
    pub fn keep(&mut self, next: &NextView, frame: Frame) -> Result<Frame, Failure> {
        self.n_taken += 1;
        let Some(kept) = self.kept.pop_front() else {
            return self
                .journal
                .keep(next.view, &frame)
                .map(|()| frame)
                .map_err(|error| self.not_kept(error.into()));
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
    pub fn finish(self) -> Result<(), Failure> {
        let path = self.dir.join(NAME);
        drop(self.journal);
        std::fs::remove_file(&path).map_err(|e| Failure::from(e).while_writing(&path))
    }

    fn not_kept(&self, failure: Failure) -> Failure {
        let before = n_frames(self.n_taken - 1);
        failure.with_hint(format!("is the disk full? --resume {} goes on after {before}", self.dir.display()))
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
