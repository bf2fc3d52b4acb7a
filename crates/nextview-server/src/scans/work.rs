use super::about::About;
use super::kept_page;
use super::summary::ScanState;
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

/// The end of the name of a folder whose files are being removed.
pub(super) const DELETED: &str = ".deleted";

/// A scan as one request has it to itself.
pub(crate) struct Work {
    dir: PathBuf,
    pub about: About,
    /// None where it is to be resumed from the disk, or is finished.
    scan: Option<Box<LiveScan>>,
    phase: Phase,
    pub cancel: Cancel,
    /// Number of frames after which listeners were told of this view.
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

    /// One that is on the disk.
    pub fn kept(dir: PathBuf, about: About) -> Self {
        let (phase, cancel) = (Phase::UnderWay, Cancel::default());
        let mut work = Self { dir, about, scan: None, phase, cancel, told: None };
        work.look();
        work
    }

    /// Notes that the scan on the disk is finished, which another process that resumed it may have done.
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

    pub fn state(&self) -> ScanState {
        match (self.phase, self.about.is_paused) {
            (Phase::UnderWay, true) => ScanState::Paused,
            (Phase::UnderWay, false) => ScanState::Running,
            _ => ScanState::Finished,
        }
    }

    /// Number of frames: those in memory or, of a scan that is finished, the lines of its file.
    pub fn n_frames(&self) -> Option<usize> {
        if let Some(scan) = &self.scan {
            return Some(scan.scan().steps.len());
        }
        let steps = || std::fs::read_to_string(self.dir.join("steps.jsonl")).ok();
        self.is_finished().then(steps)?.map(|steps| steps.lines().count())
    }

    /// What was damaged in the journal of the scan in memory when it was resumed.
    pub fn damage(&self) -> Option<String> {
        self.scan.as_ref()?.damage().map(ToString::to_string)
    }

    /// The scan to continue with, resumed if it is not in memory.
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

    /// The view to take next; none if the scan is over. That it was asked for is on the disk when this
    /// returns: the frame that comes then is that view's, whatever happens to the server before.
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

    /// Whether listeners have not been told of this view yet. Now they are.
    pub fn is_news(&mut self, view: Option<usize>) -> bool {
        let n_frames = self.scan.as_ref().map_or(0, |scan| scan.scan().steps.len());
        self.told.replace((n_frames, view)) != Some((n_frames, view))
    }

    /// Writes the results; the scan is finished even if some could not be written, which is reported.
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

    /// Removes everything of it.
    pub fn delete(&mut self) -> Result<(), Refusal> {
        if self.phase == Phase::Deleted {
            return Err(deleted());
        }
        self.scan = None;
        // At once for whoever looks, even if the server is killed while it removes the files. The name is
        // new: of a scan of the same id that was deleted before, something may be left.
        let name = self.dir.file_name().unwrap_or_default().to_string_lossy();
        let aside = self.dir.with_file_name(format!(".{name}.{}{DELETED}", random_hex(4)?));
        match std::fs::rename(&self.dir, &aside) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(Fault::from(error).while_writing(&self.dir).into());
            }
            _ => self.phase = Phase::Deleted,
        }
        // What cannot be removed now is removed when the server starts again.
        let _ = std::fs::remove_dir_all(&aside);
        Ok(())
    }

    /// It is resumed from the disk when it is needed again: after a panic, what is in memory may be anything.
    pub fn forget(&mut self) {
        self.scan = None;
    }

    fn resumed(&self) -> Result<LiveScan, Refusal> {
        let mut scan = match ScanJournal::is_in(&self.dir) {
            true => LiveScan::resume(&self.dir, self.cancel.clone())?,
            // A scan that has no frames yet leaves no journal.
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
