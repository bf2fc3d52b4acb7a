//! Files that are never half written: each is written beside its place and then renamed.

use crate::Failure;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Opens a file for reading.
pub(crate) fn open(path: &Path) -> Result<BufReader<File>, Failure> {
    if path.is_dir() {
        return Err(Failure::data("is a folder, expected a file").in_file(path));
    }
    File::open(path)
        .map(BufReader::new)
        .map_err(|e| Failure::data(format!("cannot be read: {e}")).in_file(path))
}

/// Writes a file as a whole or not at all.
pub(crate) fn write(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let beside = beside(path);
    let result = write_through(&beside, content).and_then(|()| Ok(fs::rename(&beside, path)?));
    result.map_err(|failure| {
        // The first error is the one to tell; the file beside may not even exist.
        let _ = fs::remove_file(&beside);
        unwritable(failure, path)
    })
}

fn write_through(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut writer = BufWriter::new(File::create(path)?);
    content(&mut writer)?;
    writer.flush()?;
    Ok(writer.get_ref().sync_all()?)
}

fn unwritable(failure: Failure, path: &Path) -> Failure {
    failure.in_file(path).with_hint("is the folder writable and is there space on the disk?")
}

/// A folder of results that appears as a whole or not at all.
#[derive(Debug)]
pub(crate) struct ResultFolder {
    target: PathBuf,
    staging: PathBuf,
}

impl ResultFolder {
    /// Begins a folder; fails at once if it could not be written later.
    pub fn begin(target: &Path) -> Result<Self, Failure> {
        if target.exists() && !target.is_dir() {
            return Err(Failure::data("exists and is no folder")
                .in_file(target)
                .with_hint("pass another --out"));
        }
        let folder = Self { target: target.to_owned(), staging: beside(target) };
        fs::create_dir_all(&folder.staging).map_err(|e| unwritable(e.into(), target))?;
        if target.is_dir() {
            // A read-only folder is found out now, not after the scan.
            let probe = target.join(format!(".nextview-{}", std::process::id()));
            File::create(&probe)
                .and_then(|_| fs::remove_file(&probe))
                .map_err(|e| unwritable(e.into(), target))?;
        }
        Ok(folder)
    }

    /// Adds a file.
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        write_through(&self.staging.join(name), content).map_err(|e| unwritable(e, &self.target.join(name)))
    }

    /// Shows the finished folder under its name; files of the same names that are there already are replaced.
    pub fn publish(self) -> Result<(), Failure> {
        let moved =
            if self.target.exists() { self.move_files() } else { fs::rename(&self.staging, &self.target) };
        moved.map_err(|e| unwritable(e.into(), &self.target))
    }

    fn move_files(&self) -> std::io::Result<()> {
        for entry in fs::read_dir(&self.staging)? {
            let entry = entry?;
            fs::rename(entry.path(), self.target.join(entry.file_name()))?;
        }
        Ok(())
    }
}

impl Drop for ResultFolder {
    fn drop(&mut self) {
        // Gone already if it was renamed; otherwise nothing unfinished may stay behind.
        let _ = fs::remove_dir_all(&self.staging);
    }
}

/// A name next to the path, on the same file system.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.partial", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("nextview-files-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.txt");
        write(&path, |w| Ok(w.write_all(b"old")?)).unwrap();
        let failure = write(&path, |w| {
            w.write_all(b"half of the new")?;
            Err(Failure::data("no more"))
        });
        assert!(failure.unwrap_err().to_string().contains("a.txt: no more"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);

        let results = folder.join("results");
        let unfinished = ResultFolder::begin(&results).unwrap();
        unfinished.write("x", |w| Ok(w.write_all(b"x")?)).unwrap();
        drop(unfinished);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "an unfinished folder disappears");
        for _ in 0..2 {
            let finished = ResultFolder::begin(&results).unwrap();
            finished.write("x", |w| Ok(w.write_all(b"x")?)).unwrap();
            finished.publish().unwrap();
            assert_eq!(fs::read(results.join("x")).unwrap(), b"x");
        }
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
        fs::remove_dir_all(&folder).unwrap();
    }
}
