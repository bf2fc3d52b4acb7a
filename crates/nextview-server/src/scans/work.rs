use super::about::About;
use super::kept_page;
use super::summary::ScanPhase;
use crate::access::random_hex;
use crate::refusal::Refusal;
use axum::http::StatusCode;
use nextview::Cancel;
use nextview::session::NextView;
use nextview_report::page_of_scan;
use nextview_scan::files::Overwrite;
use nextview_scan::{Fault, Faults, LiveScan, Results, ScanJournal, begin_results};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Suffix of a folder whose files are being removed.
pub(super) const DELETED: &str = ".deleted";

/// Exclusive access of one request to a scan.
pub(crate) struct Work {
    dir: PathBuf,
    pub about: About,
    /// `None` if it must be resumed from the disk, or is finished.
    scan: Option<Box<LiveScan>>,
    phase: Phase,
    pub cancel: Cancel,
    /// The view of which listeners were told last, and the number of frames at that time.
    told: Option<(usize, Option<usize>)>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    UnderWay,
    Finished,
    Deleted,
}

impl Work {
    /// A scan that has just begun.
    pub fn begun(dir: PathBuf, about: About, scan: LiveScan) -> Self {
        let cancel = scan.cancel().clone();
        Self { dir, about, scan: Some(Box::new(scan)), phase: Phase::UnderWay, cancel, told: None }
    }

    /// A scan on the disk.
    pub fn kept(dir: PathBuf, about: About) -> Self {
        let (phase, cancel) = (Phase::UnderWay, Cancel::default());
        let mut work = Self { dir, about, scan: None, phase, cancel, told: None };
        work.look();
        work
    }

    /// Updates the state if the scan on the disk is finished: another process may have resumed and finished
    /// it.
    pub fn look(&mut self) {
        let has_results = || !ScanJournal::is_in(&self.dir) && self.dir.join("record.json").is_file();
        if self.scan.is_none() && self.phase == Phase::UnderWay && has_results() {
            self.phase = Phase::Finished;
        }
    }

    /// Its folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    pub fn is_finished(&self) -> bool {
        self.phase == Phase::Finished
    }

    pub fn state(&self) -> ScanPhase {
        match (self.phase, self.about.is_paused) {
            (Phase::UnderWay, true) => ScanPhase::Paused,
            (Phase::UnderWay, false) => ScanPhase::Running,
            _ => ScanPhase::Finished,
        }
    }

    /// Number of frames: those in memory or, for a finished scan, the lines of its file.
    pub fn n_frames(&self) -> Option<usize> {
        if let Some(scan) = &self.scan {
            return Some(scan.scan().steps.len());
        }
        let steps = || std::fs::read_to_string(self.dir.join("steps.jsonl")).ok();
        self.is_finished().then(steps)?.map(|steps| steps.lines().count())
    }

    /// The damage in the journal of the scan in memory when it was resumed.
    pub fn damage(&self) -> Option<String> {
        self.scan.as_ref()?.damage().map(ToString::to_string)
    }

    /// Returns the scan, resumed if it is not in memory.
    pub fn under_way(&mut self) -> Result<(&mut LiveScan, &mut About), Refusal> {
        match self.phase {
            Phase::UnderWay => (),
            Phase::Finished => return Err(Refusal::of(StatusCode::CONFLICT, "the scan is finished")),
            Phase::Deleted => return Err(deleted()),
        }
        if self.scan.is_none() {
            self.scan = Some(Box::new(self.resumed()?));
        }
        Ok((self.scan.as_mut().expect("it was resumed"), &mut self.about))
    }

    /// Returns the next view; `None` if the scan is over. The request is on the disk on return: the next
    /// frame belongs to this view, even if the server is killed before.
    pub fn next_view(&mut self) -> Result<Option<NextView>, Refusal> {
        let dir = self.dir.clone();
        let (scan, about) = self.under_way()?;
        let (next, n_frames) = (scan.next()?, scan.scan().steps.len());
        if next.is_some() && about.asked_after != Some(n_frames) {
            let before = about.asked_after.replace(n_frames);
            about.save(&dir).inspect_err(|_| about.asked_after = before)?;
        }
        Ok(next)
    }

    /// Whether listeners have not yet been told of this view; marks it as told.
    pub fn is_news(&mut self, view: Option<usize>) -> bool {
        let n_frames = self.scan.as_ref().map_or(0, |scan| scan.scan().steps.len());
        self.told.replace((n_frames, view)) != Some((n_frames, view))
    }

    /// Writes the results. The scan is finished even if some could not be written, which is reported.
    pub fn finish(&mut self) -> Result<Option<Faults>, Refusal> {
        if self.phase == Phase::Finished {
            return Ok(None);
        }
        let dir = self.dir.clone();
        let (scan, _) = self.under_way()?;
        scan.end();
        let mut folder = begin_results(&dir, Overwrite::results())?;
        let Results { record, faults } = scan.write_results(&mut folder)?;
        let text = toml::to_string(&scan.config().kept_in(&dir)).map_err(Fault::data)?;
        let page = page_of_scan(scan.scan(), &record, scan.config(), "nextview serve", &text);
        folder.add("report.html", |w| Ok(w.write_all(page.as_bytes())?))?;
        kept_page::keep(scan, &dir)?;
        folder.publish()?;
        scan.forget_journal();
        (self.scan, self.phase) = (None, Phase::Finished);
        Ok(faults)
    }

    /// Removes the scan with all its files.
    pub fn delete(&mut self) -> Result<(), Refusal> {
        if self.phase == Phase::Deleted {
            return Err(deleted());
        }
        self.scan = None;
        // Atomic for observers, even if the server is killed while it removes the files. The name is new: a
        // deleted scan with the same id may have left files.
        let name = self.dir.file_name().unwrap_or_default().to_string_lossy();
        let aside = self.dir.with_file_name(format!(".{name}.{}{DELETED}", random_hex(4)?));
        match std::fs::rename(&self.dir, &aside) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(Fault::from(error).while_writing(&self.dir).into());
            }
            _ => self.phase = Phase::Deleted,
        }
        // Files that cannot be removed now are removed when the server restarts.
        let _ = std::fs::remove_dir_all(&aside);
        Ok(())
    }

    /// Discards the scan in memory, which may be in any state after a panic. It is resumed from the disk when
    /// needed.
    pub fn forget(&mut self) {
        self.scan = None;
    }

    fn resumed(&self) -> Result<LiveScan, Refusal> {
        let mut scan = match ScanJournal::is_in(&self.dir) {
            true => LiveScan::resume(&self.dir, self.cancel.clone())?,
            // A scan without frames leaves no journal.
            false => LiveScan::begin(self.about.config(&self.dir)?, Some(&self.dir), self.cancel.clone())?,
        };
        if self.about.asked_after == Some(scan.scan().steps.len()) {
            scan.next()?;
        }
        Ok(scan)
    }
}

pub(super) fn deleted() -> Refusal {
    Refusal::of(StatusCode::NOT_FOUND, "the scan was deleted")
}
