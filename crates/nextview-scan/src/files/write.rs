use super::{Overwrite, sync_folder};
use crate::Fault;
use std::borrow::Cow;
use std::fs::{self, File};
use std::hash::{BuildHasher, DefaultHasher, Hash, Hasher, RandomState};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file as a whole or not at all, if the rule allows it. A device or a pipe must not be replaced: it
/// is written to directly, and so is `/dev/stdout`, even if it is a regular file.
pub fn write(
    path: &Path,
    rule: &Overwrite,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let is_device = path.starts_with("/dev") || (path.exists() && !path.is_file());
    let result = if is_device {
        File::create(path).map_err(Fault::from).and_then(|file| fill(file, content))
    } else {
        rule.check_file(path)?;
        // The target of a link is replaced.
        replace(&fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()), content)
    };
    result.map_err(|fault| fault.while_writing(path))
}

fn replace(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut file = NewFile::beside(path)?;
    content(&mut file.writer)?;
    Ok(file.finish()?)
}

/// An unfinished file: it appears under its name as a whole when published. Dropping it earlier leaves
/// nothing.
#[derive(Debug)]
pub struct NewFile {
    writer: BufWriter<File>,
    path: PathBuf,
    beside: PathBuf,
}

impl NewFile {
    /// Begins a file if the rule allows it.
    pub fn begin(path: &Path, rule: &Overwrite) -> Result<Self, Fault> {
        rule.check_file(path)?;
        Self::beside(path).map_err(|error| Fault::from(error).while_writing(path))
    }

    fn beside(path: &Path) -> io::Result<Self> {
        let beside = path.with_file_name(unfinished(path));
        Ok(Self { writer: BufWriter::new(File::create(&beside)?), path: path.to_owned(), beside })
    }

    /// Publishes the file under its name.
    pub fn publish(mut self) -> Result<(), Fault> {
        self.finish().map_err(|error| Fault::from(error).while_writing(&self.path))
    }

    /// Marks the fault as one of writing this file.
    pub fn fault(&self, fault: Fault) -> Fault {
        fault.while_writing(&self.path)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.writer.flush()?;
        // On the disk before it replaces the old one.
        self.writer.get_ref().sync_all()?;
        fs::rename(&self.beside, &self.path)?;
        sync_folder(&self.path)
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        // Already gone if published; there is nobody to report a failure to.
        let _ = fs::remove_file(&self.beside);
    }
}

fn fill(file: File, content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>) -> Result<(), Fault> {
    let mut writer = BufWriter::new(file);
    content(&mut writer)?;
    Ok(writer.flush()?)
}

/// A unique name for an unfinished file, as short as file systems require. Process numbers are not unique
/// across machines or over time.
pub fn unfinished(path: &Path) -> String {
    let (name, number) = (name_of(path), RandomState::new().build_hasher().finish() as u32);
    if name.len() <= MOST_BYTES {
        return format!(".{name}.{number}.partial");
    }
    let mut hasher = DefaultHasher::new();
    name.hash(&mut hasher);
    let start = (0..=MOST_BYTES).rev().find(|&at| name.is_char_boundary(at)).unwrap_or_default();
    format!(".{}-{:x}.{number}.partial", &name[..start], hasher.finish())
}

/// Maximum length, in bytes, of the part of a name that begins an unfinished file's name.
const MOST_BYTES: usize = 200;

/// The final name of a file with an [`unfinished`] name.
pub(super) fn written_name(unfinished: &str) -> Option<&str> {
    let (name, number) = unfinished.strip_prefix('.')?.strip_suffix(".partial")?.rsplit_once('.')?;
    number.parse::<u32>().is_ok().then_some(name)
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
        write(&path, &Overwrite::nothing(), |w| Ok(w.write_all(b"old")?)).unwrap();
        let fault = write(&path, &Overwrite::results(), |w| {
            w.write_all(b"half of the new")?;
            Err(Fault::data("no more"))
        });
        assert!(fault.unwrap_err().to_string().contains("a.txt: cannot be written: no more"));
        let fault = write(&path, &Overwrite::nothing(), |w| Ok(w.write_all(b"new")?)).unwrap_err();
        assert!(fault.to_string().ends_with("a.txt: already exists"), "{fault}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_name_may_be_as_long_as_the_file_system_allows() {
        let folder = test_folder("long");
        for name in ["a".repeat(255), "ä".repeat(127)] {
            write(&folder.join(&name), &Overwrite::nothing(), |w| Ok(w.write_all(b"x")?)).unwrap();
            assert_eq!(fs::read(folder.join(name)).unwrap(), b"x");
        }
        let too_long = folder.join("a".repeat(256));
        let rule = Overwrite::nothing();
        for fault in [
            rule.check_file(&too_long).err(),
            rule.check_folder(&too_long, &["x"]).err().map(|faults| faults.iter().next().unwrap().clone()),
        ] {
            let fault = fault.unwrap();
            assert!(fault.to_string().contains("too long"), "{fault}");
            assert_eq!(fault.remedy.as_deref(), Some("a name has at most 255 bytes"));
        }
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
        write(&link, &Overwrite::results(), |w| Ok(w.write_all(b"new")?)).unwrap();
        write(&device, &Overwrite::nothing(), |w| Ok(w.write_all(b"new")?)).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(link.is_symlink() && device.is_symlink());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 3);
        fs::remove_dir_all(&folder).unwrap();
    }
}
