use super::about::About;
use super::creation::NewScan;
use super::folder::ScansFolder;
use super::scan::{Cores, Scan};
use super::summary::{ScanPhase, ScanSummary};
use super::work::{DELETED, Work};
use crate::Limits;
use crate::access::random_hex;
use crate::limits::exceeded;
use crate::refusal::Refusal;
use axum::http::StatusCode;
use chrono::{DateTime, SecondsFormat, Utc};
use nextview::Cancel;
use nextview_scan::{Fault, Faults, LiveScan, ScanConfig, files};
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;
use tokio::sync::Semaphore;

/// Whether a folder contains only the remains of a scan killed during its creation.
fn is_stillborn(dir: &Path) -> bool {
    let prefix = format!(".{}.", About::FILE);
    let is_remnant = |name: &str| name.starts_with(&prefix) && name.ends_with(".partial");
    if dir.is_symlink() {
        return false;
    }
    let Ok(entries) = fs::read_dir(dir) else { return false };
    let mut names = entries.map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()));
    names.all(|name| name.is_ok_and(|name| is_remnant(&name)))
}

/// All scans of a server, each in its own folder.
pub(crate) struct Scans {
    folder: ScansFolder,
    limits: Limits,
    /// Distinguishes the events of this process from those of an earlier one.
    run: String,
    cores: Cores,
    scans: Mutex<BTreeMap<String, IdState>>,
}

/// The state of an id.
struct IdState {
    /// The scan; `None` while it is being created.
    scan: Option<Arc<Scan>>,
    /// The id of the scan that it continues, which it needs until it is finished.
    after: Option<String>,
    /// Whether it is being deleted: nothing that needs it may begin.
    is_leaving: bool,
}

impl IdState {
    fn is_finished(&self) -> bool {
        self.scan.as_ref().is_some_and(|scan| scan.summary().state == ScanPhase::Finished)
    }

    /// Whether it needs the files of this scan.
    fn needs(&self, id: &str) -> bool {
        self.after.as_deref() == Some(id) && !self.is_finished()
    }
}

/// An id reserved for a scan being created, and with it the scan that it continues.
struct ReservedId<'a> {
    scans: &'a Scans,
    id: &'a str,
}

impl ReservedId<'_> {
    fn fill(self, scan: &Arc<Scan>) {
        if let Some(entry) = self.scans.lock().get_mut(self.id) {
            entry.scan = Some(scan.clone());
        }
    }
}

impl Drop for ReservedId<'_> {
    /// Releases the id if no scan was created, even after a panic.
    fn drop(&mut self) {
        let mut scans = self.scans.lock();
        if scans.get(self.id).is_some_and(|entry| entry.scan.is_none()) {
            scans.remove(self.id);
        }
    }
}

/// A scan being deleted. Unless it is [gone](Self::gone), it continues when this is dropped.
pub(crate) struct Leaving {
    scans: Arc<Scans>,
    id: String,
    pub scan: Arc<Scan>,
}

impl Leaving {
    /// Marks it as removed from the disk.
    pub fn gone(self) {
        self.scans.lock().remove(&self.id);
    }
}

impl Drop for Leaving {
    fn drop(&mut self) {
        if let Some(entry) = self.scans.lock().get_mut(&self.id).filter(|entry| entry.is_leaving) {
            entry.is_leaving = false;
        }
        self.scan.go_on();
    }
}

impl Scans {
    /// Opens the scans in the folder. Returns faults for those that cannot be read, which are left out. Their
    /// folders, and unrelated ones, are not touched.
    pub fn open(folder: ScansFolder, limits: Limits) -> Result<(Self, Vec<Faults>), Faults> {
        let n_cores = std::thread::available_parallelism().map_or(1, usize::from);
        let [requests, scenes] = [n_cores, 1].map(|n| Arc::new(Semaphore::new(n)));
        let (scans, cores, run) = (Mutex::default(), Cores { requests, scenes }, random_hex(4)?);
        let all = Self { folder, limits, run, cores, scans };
        let mut left_out = Vec::new();
        for entry in fs::read_dir(all.dir()).map_err(|e| Fault::from(e).in_file(all.dir()))? {
            let dir = entry?.path();
            let id = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if id.starts_with('.') && id.ends_with(DELETED) {
                fs::remove_dir_all(&dir).map_err(|e| Fault::from(e).while_writing(&dir))?;
            } else if dir.join(About::FILE).is_file() {
                match all.kept(&id, dir) {
                    Ok(entry) => _ = all.lock().insert(id, entry),
                    Err(faults) => left_out.push(faults),
                }
            }
        }
        Ok((all, left_out))
    }

    /// Opens the scan kept in a folder. Fails if it cannot be resumed because the scan that it continues is
    /// missing.
    fn kept(&self, id: &str, dir: PathBuf) -> Result<IdState, Faults> {
        let (about, config) = About::load(&dir)?;
        let work = Work::kept(dir, about);
        if !work.is_finished() {
            config.check_earlier()?;
        }
        let after = config.after.as_deref().and_then(|after| self.id_of(after));
        let shared = (self.cores.clone(), &self.limits);
        let scan = Scan::new(id.to_owned(), self.run.clone(), work, &config, shared);
        Ok(IdState { scan: Some(Arc::new(scan)), after, is_leaving: false })
    }

    /// The id of a scan by its folder, whatever form the path has; `None` if the folder is not in this
    /// server's.
    fn id_of(&self, dir: &Path) -> Option<String> {
        let dir = dir.canonicalize().ok()?;
        let is_one = dir.parent() == Some(self.dir());
        is_one.then(|| dir.file_name().unwrap_or_default().to_string_lossy().into_owned())
    }

    /// Lists all scans by id.
    pub fn list(&self) -> Vec<ScanSummary> {
        self.all().iter().map(|scan| scan.summary()).collect()
    }

    pub fn find(&self, id: &str) -> Result<Arc<Scan>, Refusal> {
        self.lock().get(id).and_then(|entry| entry.scan.clone()).ok_or_else(|| unknown(id))
    }

    /// Begins a scan; it is on the disk on return. This is slow.
    pub fn create(&self, new: NewScan) -> Result<Arc<Scan>, Refusal> {
        self.folder.check_in_place()?;
        let place = self.reserve(&new.id, new.after.as_deref())?;
        let before = new.after.as_ref().map(|id| -> Result<ScanConfig, Faults> {
            let dir = self.dir().join(id);
            Ok(ScanConfig { after: Some(dir.clone()), ..About::load(&dir)?.1 })
        });
        let config = new.config(before.transpose()?, &self.limits)?;
        let scan = self.begin(&new.id, config, new.confirm_views)?;
        place.fill(&scan);
        Ok(scan)
    }

    /// Hides a scan from other requests to delete it, and stops its computations. Fails if an unfinished
    /// scan, or one being created, continues it.
    pub fn leave(self: &Arc<Self>, id: &str) -> Result<Leaving, Refusal> {
        self.folder.check_in_place()?;
        let mut scans = self.lock();
        let found = scans.get(id).and_then(|entry| Some((entry.scan.clone()?, entry.is_leaving)));
        let (scan, is_leaving) = found.ok_or_else(|| unknown(id))?;
        if is_leaving {
            return Err(Refusal::of(StatusCode::CONFLICT, "the scan is being deleted"));
        }
        if let Some((by, _)) = scans.iter().find(|(_, entry)| entry.needs(id)) {
            let fault = Fault::of_value("id", id, "a scan that no unfinished scan continues");
            let fault = fault.with_remedy(format!("finish or delete `{by}` first"));
            return Err(Refusal::new(StatusCode::CONFLICT, fault));
        }
        scans.entry(id.to_owned()).and_modify(|entry| entry.is_leaving = true);
        scan.cancel();
        Ok(Leaving { scans: self.clone(), id: id.to_owned(), scan })
    }

    /// Number of scans that are not finished.
    pub fn n_interrupted(&self) -> usize {
        self.list().iter().filter(|scan| scan.state != ScanPhase::Finished).count()
    }

    /// Resumes all interrupted scans, one after the other.
    pub async fn resume_all(&self) {
        for scan in self.all() {
            if scan.summary().state != ScanPhase::Finished {
                // A fault is reported to the next request for the scan.
                let _ = scan.with(|work| work.under_way().map(drop)).await;
            }
        }
    }

    /// Free disk space; `None` if unknown.
    pub fn free_disk_mb(&self) -> Option<u64> {
        #[cfg(unix)]
        return rustix::fs::statvfs(self.dir()).ok().map(|disk| (disk.f_bavail * disk.f_frsize) >> 20);
        #[cfg(not(unix))]
        None
    }

    /// Reserves an id, which prevents two scans in one folder, and protects the continued scan from deletion.
    fn reserve<'a>(&'a self, id: &'a str, after: Option<&str>) -> Result<ReservedId<'a>, Refusal> {
        let mut scans = self.lock();
        let n_open = scans.values().filter(|entry| !entry.is_finished()).count();
        if scans.contains_key(id) || self.is_taken(id) {
            return Err(taken(id));
        }
        if n_open >= self.limits.scans {
            let fault = exceeded("scans", n_open + 1, format!("{} scans under way", self.limits.scans));
            let fault = fault.with_remedy("finish or delete one");
            return Err(Refusal::new(StatusCode::SERVICE_UNAVAILABLE, fault));
        }
        let is_there = |id: &str| scans.get(id).is_some_and(|entry| entry.is_finished() && !entry.is_leaving);
        if let Some(before) = after.filter(|id| !is_there(id)) {
            let before: String = before.chars().take(80).collect();
            return Err(Refusal::content(Fault::of_value("after", before, "the id of a finished scan")));
        }
        let after = after.map(str::to_owned);
        scans.insert(id.to_owned(), IdState { scan: None, after, is_leaving: false });
        Ok(ReservedId { scans: self, id })
    }

    /// Whether the name is taken by anything, even a dangling link.
    fn is_taken(&self, id: &str) -> bool {
        let dir = self.dir().join(id);
        dir.symlink_metadata().is_ok() && !is_stillborn(&dir)
    }

    fn begin(&self, id: &str, config: ScanConfig, confirm_views: bool) -> Result<Arc<Scan>, Refusal> {
        let dir = self.dir().join(id);
        let text = toml::to_string(&config.kept_in(&dir)).map_err(Fault::data)?;
        let about = About {
            created: DateTime::<Utc>::from(SystemTime::now()).to_rfc3339_opts(SecondsFormat::Secs, true),
            confirm_views,
            is_paused: false,
            accepted_after: None,
            asked_after: None,
            config: text,
        };
        let summary_config = config.clone();
        self.make_folder(id, &dir)?;
        // First the file that marks the folder as a scan's: a scan killed here can continue.
        let begun = about.save(&dir).map_err(Refusal::from).and_then(|()| {
            let cancel = Cancel::default();
            LiveScan::begin(config, Some(&dir), cancel).map_err(Refusal::content)
        });
        // Nothing else is removed: another program may have begun a scan there, too.
        let scan = begun.inspect_err(|_| {
            let _ = fs::remove_file(dir.join(About::FILE));
            let _ = fs::remove_dir(&dir);
        })?;
        let work = Work::begun(dir, about, scan);
        let shared = (self.cores.clone(), &self.limits);
        Ok(Arc::new(Scan::new(id.to_owned(), self.run.clone(), work, &summary_config, shared)))
    }

    /// Creates the folder of a scan. Fails if another program has created it in the meantime.
    fn make_folder(&self, id: &str, dir: &Path) -> Result<(), Refusal> {
        match fs::create_dir(dir) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists && is_stillborn(dir) => {
                files::remove_unfinished(dir, &[About::FILE])
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => return Err(taken(id)),
            // The frames in it are safe on the disk only if the folder is.
            Ok(()) if cfg!(unix) => fs::File::open(self.dir()).and_then(|folder| folder.sync_all()),
            result => result,
        }
        .map_err(|e| Fault::from(e).while_writing(dir).into())
    }

    /// The folder of all scans.
    fn dir(&self) -> &Path {
        self.folder.path()
    }

    fn all(&self) -> Vec<Arc<Scan>> {
        self.lock().values().filter_map(|entry| entry.scan.clone()).collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, IdState>> {
        self.scans.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn unknown(id: &str) -> Refusal {
    let fault = Fault::of_value("id", id.chars().take(80).collect::<String>(), "the id of a scan");
    Refusal::new(StatusCode::NOT_FOUND, fault.with_remedy("`GET /scans` lists all"))
}

fn taken(id: &str) -> Refusal {
    let fault = Fault::of_value("id", id, "an id that no other scan has");
    Refusal::new(StatusCode::CONFLICT, fault.with_remedy("choose another, or leave it out"))
}
