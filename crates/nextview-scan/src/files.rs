//! Files that are never half written: each is written beside its place and then renamed.

use crate::Fault;
use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Opens a file for reading.
pub fn open(path: &Path) -> Result<BufReader<File>, Fault> {
    if path.is_dir() {
        return Err(Fault::data("is a folder, expected a file").in_file(path));
    }
    File::open(path)
        .map(BufReader::new)
        .map_err(|e| Fault::data(format!("cannot be read: {e}")).in_file(path))
}

/// Writes a file as a whole or not at all. A device or a pipe must not be replaced: it is written to as it
/// is, and so is `/dev/stdout`, even where it stands for a regular file.
pub fn write(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let is_device = path.starts_with("/dev") || (path.exists() && !path.is_file());
    let result = if is_device {
        File::create(path).map_err(Fault::from).and_then(|file| fill(file, content)).map(drop)
    } else {
        // Of a link, the file it names is replaced.
        replace(&fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()), content)
    };
    result.map_err(|fault| fault.while_writing(path))
}

fn replace(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let beside = path.with_file_name(unfinished(path));
    let whole = || {
        // On the disk before it takes the old one's place.
        fill(File::create(&beside)?, content)?.sync_all()?;
        Ok(fs::rename(&beside, path)?)
    };
    whole().inspect_err(|_| {
        // The first error is the one to report; the file beside may not even exist.
        let _ = fs::remove_file(&beside);
    })
}

fn fill(file: File, content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>) -> Result<File, Fault> {
    let mut writer = BufWriter::new(file);
    content(&mut writer)?;
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// Removes what writing into this folder has left unfinished; nobody must be writing into it.
pub fn remove_unfinished(folder: &Path) -> io::Result<()> {
    let prefix = format!(".{}.", name_of(folder));
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let is_unfinished =
            name.to_str().is_some_and(|name| name.starts_with(&prefix) && name.ends_with(".partial"));
        if is_unfinished && entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        }
    }
    Ok(())
}

/// A folder of results that appears as a whole or not at all. Until then its files are kept in memory.
#[derive(Debug)]
pub struct ResultFolder {
    target: PathBuf,
    /// Where the files are written first: on the same file system as the target.
    staging: PathBuf,
    files: Vec<(&'static str, Vec<u8>)>,
}

impl ResultFolder {
    /// Begins a folder; fails at once if it could not be written later.
    pub fn begin(target: &Path) -> Result<Self, Fault> {
        if target.exists() && !target.is_dir() {
            return Err(Fault::data("exists and is no folder")
                .in_file(target)
                .with_remedy("choose another folder (`out`)"));
        }
        let staging = nearest_existing(target).join(unfinished(target));
        fs::create_dir(&staging)
            .and_then(|()| fs::remove_dir(&staging))
            .map_err(|e| Fault::from(e).while_writing(target))?;
        Ok(Self { target: target.to_owned(), staging, files: Vec::new() })
    }

    /// Adds a file.
    pub fn add(
        &mut self,
        name: &'static str,
        content: impl FnOnce(&mut Vec<u8>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let mut bytes = Vec::new();
        content(&mut bytes)?;
        self.files.push((name, bytes));
        Ok(())
    }

    /// Shows the finished folder under its name; files of the same names that are there already are replaced.
    pub fn publish(self) -> Result<(), Fault> {
        let result = self.write().and_then(|()| {
            let moved = if self.target.exists() { self.move_files() } else { self.move_folder() };
            moved.map_err(|e| Fault::from(e).while_writing(&self.target))
        });
        result.inspect_err(|_| {
            let _ = fs::remove_dir_all(&self.staging);
        })
    }

    fn write(&self) -> Result<(), Fault> {
        fs::create_dir(&self.staging).map_err(|e| Fault::from(e).while_writing(&self.target))?;
        for (name, bytes) in &self.files {
            let written = File::create(self.staging.join(name)).and_then(|mut file| {
                file.write_all(bytes)?;
                file.sync_all()
            });
            written.map_err(|e| Fault::from(e).while_writing(&self.target.join(name)))?;
        }
        Ok(())
    }

    fn move_folder(&self) -> io::Result<()> {
        if let Some(parent) = self.target.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::rename(&self.staging, &self.target)
    }

    fn move_files(&self) -> io::Result<()> {
        for (name, _) in &self.files {
            fs::rename(self.staging.join(name), self.target.join(name))?;
        }
        fs::remove_dir(&self.staging)
    }
}

/// The path itself if it exists, or else the nearest folder above it that does.
fn nearest_existing(path: &Path) -> &Path {
    path.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."))
}

/// The name under which something is written until it is whole.
fn unfinished(path: &Path) -> String {
    format!(".{}.{}.partial", name_of(path), std::process::id())
}

fn name_of(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("nextview-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = test_folder("write");
        let path = folder.join("a.txt");
        write(&path, |w| Ok(w.write_all(b"old")?)).unwrap();
        let fault = write(&path, |w| {
            w.write_all(b"half of the new")?;
            Err(Fault::data("no more"))
        });
        assert!(fault.unwrap_err().to_string().contains("a.txt: cannot be written: no more"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_folder_of_results_appears_as_a_whole() {
        let folder = test_folder("results");
        let unfinished = |path: &Path| {
            let mut results = ResultFolder::begin(path).unwrap();
            results.add("x", |w| Ok(w.write_all(b"x")?)).unwrap();
            results
        };
        let path = folder.join("new/results");
        drop(unfinished(&path));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "an unfinished folder leaves nothing");
        for _ in 0..2 {
            unfinished(&path).publish().unwrap();
            assert_eq!(fs::read(path.join("x")).unwrap(), b"x");
            assert_eq!(fs::read_dir(&path).unwrap().count(), 1);
        }
        assert_eq!(fs::read_dir(folder.join("new")).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_stay_what_they_are() {
        let folder = test_folder("links");
        let (file, link, device) = (folder.join("file"), folder.join("link"), folder.join("device"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        std::os::unix::fs::symlink("/dev/null", &device).unwrap();
        write(&link, |w| Ok(w.write_all(b"new")?)).unwrap();
        write(&device, |w| Ok(w.write_all(b"new")?)).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(link.is_symlink() && device.is_symlink());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 3);
        fs::remove_dir_all(&folder).unwrap();
    }
}
