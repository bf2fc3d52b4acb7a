use super::Overwrite;
use crate::Fault;
use std::borrow::Cow;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

/// Writes a file as a whole or not at all, where the rule allows it. A device or a pipe must not be replaced:
/// it is written to as it is, and so is `/dev/stdout`, even where it stands for a regular file.
pub fn write(
    path: &Path,
    rule: &Overwrite,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let is_device = path.starts_with("/dev") || (path.exists() && !path.is_file());
    let result = if is_device {
        File::create(path).map_err(Fault::from).and_then(|file| fill(file, content)).map(drop)
    } else {
        rule.check_file(path)?;
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

/// The name under which something is written until it is whole.
pub(super) fn unfinished(path: &Path) -> String {
    format!(".{}.{}.partial", name_of(path), std::process::id())
}

pub(super) fn name_of(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::path::PathBuf;

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
        assert!(fault.to_string().ends_with("a.txt: exists already"), "{fault}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
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
