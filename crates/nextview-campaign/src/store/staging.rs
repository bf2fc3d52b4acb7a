use nextview_scan::{Fault, files};
use std::fs;
use std::path::{Path, PathBuf};

/// A new folder in progress: written next to its target under another name, and renamed when complete.
/// Removed if dropped before.
#[derive(Debug)]
pub(super) struct Staging {
    target: PathBuf,
    path: PathBuf,
}

impl Staging {
    /// Fails if the target exists, or if it is not writable.
    pub fn begin(target: &Path) -> Result<Self, Fault> {
        files::check_name(target)?;
        let is_free = match fs::read_dir(target) {
            Ok(mut entries) => entries.next().is_none(),
            Err(_) => !target.exists(),
        };
        if !is_free {
            let fault = Fault::data("is not empty, and existing files are not replaced").in_file(target);
            return Err(fault.with_remedy("choose another folder (`out`)"));
        }
        let path = target.with_file_name(files::unfinished(target));
        fs::create_dir_all(&path).map_err(|error| Fault::from(error).while_writing(target))?;
        Ok(Self { target: target.to_owned(), path })
    }

    /// The folder to write to.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Renames the folder to its target. Fails if the target has appeared.
    pub fn publish(self) -> Result<(), Fault> {
        // Not every system renames over an empty folder; a folder with content stays.
        let _ = fs::remove_dir(&self.target);
        fs::rename(&self.path, &self.target).map_err(|error| Fault::from(error).while_writing(&self.target))
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Gone if it was published.
        let _ = fs::remove_dir_all(&self.path);
    }
}
