use super::about::About;
use nextview_scan::Fault;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The folder of all scans, used by one server at a time.
pub(crate) struct ScansFolder {
    /// Without links: a folder in it has a unique path.
    path: PathBuf,
    /// Locked while it is open. The file is never removed: a new one of its name would have a separate lock.
    lock: File,
}

impl ScansFolder {
    /// Name of the locked file; no scan can have it.
    const LOCK: &str = ".nextview-serve.lock";

    /// Takes the folder, which is created if missing. Fails if another server has it, or if it belongs to a
    /// scan, which may be deleted with all its content.
    pub fn take(dir: &Path) -> Result<Self, Fault> {
        fs::create_dir_all(dir).map_err(|e| Fault::from(e).while_writing(dir))?;
        let path = dir.canonicalize().map_err(|e| Fault::from(e).in_file(dir))?;
        if let Some(scan) = path.ancestors().find(|folder| folder.join(About::FILE).is_file()) {
            let fault = Fault::data("is in the folder of a scan, which may be deleted").in_file(dir);
            let around = scan.parent().unwrap_or(scan).display();
            return Err(fault.with_remedy(format!("`dir` = {around} serves all scans there")));
        }
        let file = path.join(Self::LOCK);
        let lock = OpenOptions::new().create(true).truncate(false).write(true).open(&file);
        let lock = lock.map_err(|e| Fault::from(e).while_writing(&file))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { path, lock }),
            // Some file systems have no locks.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                Ok(Self { path, lock })
            }
            Err(TryLockError::Error(error)) => Err(Fault::from(error).while_writing(&file)),
            Err(TryLockError::WouldBlock) => {
                let fault = Fault::data("is already served by another server").in_file(dir);
                Err(fault
                    .with_remedy("send requests to that server, stop it, or serve another folder (`dir`)"))
            }
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Fails if the folder was replaced: the new one does not belong to this server.
    pub fn check_in_place(&self) -> Result<(), Fault> {
        match self.is_in_place() {
            Ok(true) => Ok(()),
            Ok(false) => Err(self.replaced()),
            Err(error) if error.kind() == ErrorKind::NotFound => Err(self.replaced()),
            Err(error) => Err(Fault::from(error).in_file(&self.path)),
        }
    }

    fn replaced(&self) -> Fault {
        Fault::data("the folder of all scans was moved, removed or replaced while it was served")
            .in_file(&self.path)
    }

    #[cfg(unix)]
    fn is_in_place(&self) -> std::io::Result<bool> {
        use std::os::unix::fs::MetadataExt;
        let [there, locked] = [self.path.join(Self::LOCK).metadata()?, self.lock.metadata()?];
        Ok((there.dev(), there.ino()) == (locked.dev(), locked.ino()))
    }

    /// On other systems, a folder with an open file cannot be moved.
    #[cfg(not(unix))]
    fn is_in_place(&self) -> std::io::Result<bool> {
        self.lock.metadata().map(|of| of.is_file())
    }
}
