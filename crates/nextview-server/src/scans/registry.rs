use super::about::About;
use super::creation::NewScan;
use super::scan::{Cores, Scan};
use super::summary::{ScanState, ScanSummary};
use super::work::{DELETED, Work};
use crate::Limits;
use crate::access::random_hex;
use crate::limits::exceeded;
use crate::refusal::Refusal;
use axum::http::StatusCode;
use chrono::{DateTime, SecondsFormat, Utc};
use nextview::Cancel;
use nextview_scan::{Fault, Faults, LiveScan};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;
use tokio::sync::Semaphore;

/// Whether a folder holds no more than what a kill leaves of a scan that was just being created.
fn is_stillborn(dir: &Path) -> bool {
    let prefix = format!(".{}.", About::FILE);
    let is_remnant = |name: &str| name.starts_with(&prefix) && name.ends_with(".partial");
    let Ok(entries) = std::fs::read_dir(dir) else { return false };
    let mut names = entries.map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()));
    names.all(|name| name.is_ok_and(|name| is_remnant(&name)))
}

/// All scans of a server, each in a folder of its own.
pub(crate) struct Scans {
    dir: PathBuf,
    limits: Limits,
    /// Tells what happens in this process from what happened in one before.
    run: String,
    cores: Cores,
    /// None where a scan of this id is being created.
    scans: Mutex<BTreeMap<String, Option<Arc<Scan>>>>,
}

impl Scans {
    /// Those in the folder, which is made where it is missing, and what is wrong with scans that cannot be
    /// read: these are left out. Their folders, and folders of something else, stay as they are.
    pub fn open(dir: &Path, limits: Limits) -> Result<(Self, Vec<Faults>), Faults> {
        std::fs::create_dir_all(dir).map_err(|e| Fault::from(e).while_writing(dir))?;
        let n_cores = std::thread::available_parallelism().map_or(1, usize::from);
        let [requests, scenes] = [n_cores, 1].map(|n| Arc::new(Semaphore::new(n)));
        let cores = Cores { requests, scenes };
        let run = random_hex(4)?;
        let (mut scans, mut left_out) = (BTreeMap::new(), Vec::new());
        for entry in std::fs::read_dir(dir).map_err(|e| Fault::from(e).in_file(dir))? {
            let dir = entry?.path();
            let id = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if id.starts_with('.') && id.ends_with(DELETED) {
                std::fs::remove_dir_all(&dir).map_err(|e| Fault::from(e).while_writing(&dir))?;
            } else if dir.join(About::FILE).is_file() {
                let (about, config) = match About::load(&dir) {
                    Ok(known) => known,
                    Err(faults) => {
                        left_out.push(faults);
                        continue;
                    }
                };
                let work = Work::kept(dir, about);
                let scan = Scan::new(id.clone(), run.clone(), work, &config, (cores.clone(), &limits));
                scans.insert(id, Some(Arc::new(scan)));
            }
        }
        Ok((Self { dir: dir.to_owned(), limits, run, cores, scans: Mutex::new(scans) }, left_out))
    }

    /// All, by id.
    pub fn list(&self) -> Vec<ScanSummary> {
        self.all().iter().map(|scan| scan.summary()).collect()
    }

    pub fn find(&self, id: &str) -> Result<Arc<Scan>, Refusal> {
        self.lock().get(id).cloned().flatten().ok_or_else(|| {
            let fault = Fault::of_value("id", id.chars().take(80).collect::<String>(), "the id of a scan");
            Refusal::new(StatusCode::NOT_FOUND, fault.with_remedy("`GET /scans` lists all"))
        })
    }

    /// The folder with the results of a finished scan.
    pub fn results(&self, id: &str) -> Result<PathBuf, Fault> {
        let is_finished = |scan: &Arc<Scan>| scan.summary().state == ScanState::Finished;
        let scan = self.lock().get(id).cloned().flatten().filter(is_finished);
        let id: String = id.chars().take(80).collect();
        match scan {
            Some(_) => Ok(self.dir.join(id)),
            None => Err(Fault::of_value("after", id, "the id of a finished scan")),
        }
    }

    /// Begins a scan: on the disk when this returns. Takes a while.
    pub fn create(&self, new: NewScan) -> Result<Arc<Scan>, Refusal> {
        let NewScan { id, confirm_views, config } = new;
        self.reserve(&id)?;
        let dir = self.dir.join(&id);
        let scan = self.begin(&id, &dir, config, confirm_views);
        let mut scans = self.lock();
        match scan {
            Ok(scan) => {
                scans.insert(id, Some(scan.clone()));
                Ok(scan)
            }
            Err(refusal) => {
                scans.remove(&id);
                Err(refusal)
            }
        }
    }

    /// Fails if an unfinished scan continues this one.
    pub fn check_not_needed(&self, id: &str) -> Result<(), Refusal> {
        let dir = self.dir.join(id);
        let scans = self.lock();
        let needs = |scan: &Arc<Scan>| scan.needs(&dir);
        let Some((by, _)) = scans.iter().find(|(_, scan)| scan.as_ref().is_some_and(needs)) else {
            return Ok(());
        };
        let fault = Fault::of_value("id", id, "a scan that no unfinished scan continues");
        Err(Refusal::new(StatusCode::CONFLICT, fault.with_remedy(format!("finish or delete `{by}` first"))))
    }

    /// Removes a scan from the list, once it is no more on the disk.
    pub fn remove(&self, id: &str) {
        self.lock().remove(id);
    }

    /// Number of scans that are not finished.
    pub fn n_interrupted(&self) -> usize {
        self.list().iter().filter(|scan| scan.state != ScanState::Finished).count()
    }

    /// Resumes all scans that were interrupted, one after the other.
    pub async fn resume_all(&self) {
        for scan in self.all() {
            if scan.summary().state != ScanState::Finished {
                // Whoever asks for the scan is told what is wrong with it.
                let _ = scan.with(|work| work.under_way().map(drop)).await;
            }
        }
    }

    /// Free space of the disk; none where it is not known.
    pub fn free_disk_mb(&self) -> Option<u64> {
        #[cfg(unix)]
        return rustix::fs::statvfs(&self.dir).ok().map(|disk| (disk.f_bavail * disk.f_frsize) >> 20);
        #[cfg(not(unix))]
        None
    }

    /// Takes an id, so that no two scans are created in one folder.
    fn reserve(&self, id: &str) -> Result<(), Refusal> {
        let mut scans = self.lock();
        let is_open = |scan: &&Option<Arc<Scan>>| {
            scan.as_ref().is_none_or(|scan| scan.summary().state != ScanState::Finished)
        };
        let n_open = scans.values().filter(is_open).count();
        if scans.contains_key(id) || self.is_taken(id) {
            let fault = Fault::of_value("id", id, "an id that no other scan has");
            return Err(Refusal::new(
                StatusCode::CONFLICT,
                fault.with_remedy("choose another, or leave it out"),
            ));
        }
        if n_open >= self.limits.scans {
            let fault = exceeded("scans", n_open + 1, format!("{} scans under way", self.limits.scans));
            let fault = fault.with_remedy("finish or delete one");
            return Err(Refusal::new(StatusCode::SERVICE_UNAVAILABLE, fault));
        }
        scans.insert(id.to_owned(), None);
        Ok(())
    }

    /// Whether there is something else under this name.
    fn is_taken(&self, id: &str) -> bool {
        let dir = self.dir.join(id);
        dir.exists() && !is_stillborn(&dir)
    }

    fn begin(
        &self,
        id: &str,
        dir: &Path,
        config: nextview_scan::ScanConfig,
        confirm_views: bool,
    ) -> Result<Arc<Scan>, Refusal> {
        let text = toml::to_string(&config).map_err(Fault::data)?;
        let about = About {
            created: DateTime::<Utc>::from(SystemTime::now()).to_rfc3339_opts(SecondsFormat::Secs, true),
            confirm_views,
            is_paused: false,
            accepted_after: None,
            asked_after: None,
            config: text,
        };
        let summary_config = config.clone();
        std::fs::create_dir_all(dir).map_err(|e| Fault::from(e).while_writing(dir))?;
        // First what says that the folder is a scan's: a kill then leaves one that goes on.
        let begun = about.save(dir).map_err(Refusal::from).and_then(|()| {
            let cancel = Cancel::default();
            LiveScan::begin(config, Some(dir), cancel).map_err(Refusal::content)
        });
        let scan = begun.inspect_err(|_| _ = std::fs::remove_dir_all(dir))?;
        let work = Work::begun(dir.to_owned(), about, scan);
        let shared = (self.cores.clone(), &self.limits);
        Ok(Arc::new(Scan::new(id.to_owned(), self.run.clone(), work, &summary_config, shared)))
    }

    fn all(&self) -> Vec<Arc<Scan>> {
        self.lock().values().flatten().cloned().collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Option<Arc<Scan>>>> {
        self.scans.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
