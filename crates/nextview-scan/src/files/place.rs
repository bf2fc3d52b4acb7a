//! Resolving and assigning names of files.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// What the path of an open file leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PathTarget {
    /// The file.
    There,
    /// Another file.
    Replaced,
    /// Nothing; the file has been renamed.
    Moved,
    /// Nothing; the file has no name left, and disappears when closed.
    Removed,
}

/// What the path leads to through which the file was opened.
pub(crate) fn path_target(path: &Path, file: &File) -> io::Result<PathTarget> {
    let own = file.metadata()?;
    let is_named = n_names(&own) > 0;
    match fs::metadata(path) {
        Ok(there) if is_same(&there, &own) => Ok(PathTarget::There),
        Ok(_) => Ok(PathTarget::Replaced),
        Err(error) if !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Err(error),
        Err(_) => Ok(if is_named { PathTarget::Moved } else { PathTarget::Removed }),
    }
}

#[cfg(unix)]
fn is_same(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(unix)]
fn n_names(of: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::nlink(of)
}

/// On other systems, `std` knows no number of a file.
#[cfg(not(unix))]
fn is_same(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    (a.created().ok(), a.len()) == (b.created().ok(), b.len())
}

#[cfg(not(unix))]
fn n_names(_: &fs::Metadata) -> u64 {
    1
}

/// Renames a finished file; the new name is on the disk on return. Fails if a file of this name exists, even
/// one created concurrently.
pub(crate) fn name_new(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Ok(()) => _ = fs::remove_file(from),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => return Err(error),
        // Some file systems have no hard links: an empty, locked file of ours reserves the name.
        Err(_) => {
            let ours = File::create_new(to)?;
            _ = ours.try_lock();
            fs::rename(from, to).inspect_err(|_| _ = fs::remove_file(to))?;
        }
    }
    sync_folder(to)
}

/// Creates a folder and its missing parents; they are on the disk on return. Returns the topmost one created.
pub(crate) fn create_folder(dir: &Path) -> io::Result<Option<PathBuf>> {
    let missing: Vec<&Path> =
        dir.ancestors().take_while(|dir| !dir.as_os_str().is_empty() && !dir.exists()).collect();
    fs::create_dir_all(dir)?;
    missing.iter().rev().try_for_each(|dir| sync_folder(dir))?;
    Ok(missing.last().map(|&dir| dir.to_owned()))
}

/// Syncs the folder of a file or folder: its name then survives a power failure.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // On other systems a folder cannot be opened, and need not be.
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_open_file_is_found_or_said_to_be_elsewhere() {
        let folder = std::env::temp_dir().join(format!("nextview-place-{}", std::process::id()));
        let inner = folder.join("a/b");
        assert_eq!(create_folder(&inner).unwrap(), Some(folder.clone()));
        assert_eq!(create_folder(&inner).unwrap(), None);
        let (path, beside) = (inner.join("file"), inner.join("beside"));
        fs::write(&beside, "whole").unwrap();
        name_new(&beside, &path).unwrap();
        assert!(!beside.exists());
        let file = File::open(&path).unwrap();
        let now = || path_target(&path, &file).unwrap();
        assert_eq!(now(), PathTarget::There);
        fs::rename(folder.join("a"), folder.join("c")).unwrap();
        assert_eq!(now(), PathTarget::Moved);
        fs::create_dir_all(&inner).unwrap();
        fs::copy(folder.join("c/b/file"), &path).unwrap();
        assert_eq!(now(), PathTarget::Replaced);
        fs::remove_dir_all(folder.join("a")).unwrap();
        std::os::unix::fs::symlink("c", folder.join("a")).unwrap();
        assert_eq!(now(), PathTarget::There);
        fs::write(&beside, "other").unwrap();
        assert_eq!(name_new(&beside, &path).unwrap_err().kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        fs::remove_file(&path).unwrap();
        assert_eq!(now(), PathTarget::Removed);
        fs::remove_dir_all(&folder).unwrap();
    }
}
