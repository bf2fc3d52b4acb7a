use crate::{Fault, Faults};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The rule for overwriting files: never an input file, and other files only on request.
///
/// An input file is recognised under any name, through symbolic and hard links.
///
/// ```
/// use nextview_scan::files::{Overwrite, write};
/// use std::io::Write;
///
/// let path = std::env::temp_dir().join(format!("nextview-doc-{}.txt", std::process::id()));
/// let put = |rule: &Overwrite| write(&path, rule, |w| Ok(w.write_all(b"text")?));
/// put(&Overwrite::nothing())?;
/// assert!(put(&Overwrite::nothing()).is_err(), "it exists");
/// put(&Overwrite::results())?;
/// assert!(put(&Overwrite::results().but(vec![path.clone()])).is_err(), "it is read");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), nextview_scan::Faults>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overwrite {
    replaces: bool,
    inputs: Vec<PathBuf>,
}

impl Overwrite {
    /// Allows no existing file.
    pub fn nothing() -> Self {
        Self { replaces: false, inputs: Vec::new() }
    }

    /// Allows existing files, such as earlier results.
    pub fn results() -> Self {
        Self { replaces: true, inputs: Vec::new() }
    }

    /// Allows existing files if forced, otherwise none.
    pub fn forced(is_forced: bool) -> Self {
        if is_forced { Self::results() } else { Self::nothing() }
    }

    /// Protects these input files.
    pub fn but(self, inputs: Vec<PathBuf>) -> Self {
        Self { inputs, ..self }
    }

    /// Fails if this file must not be written.
    pub fn check_file(&self, file: &Path) -> Result<(), Fault> {
        check_name(file)?;
        if self.is_input(file) {
            return Err(input(file).with_remedy("choose another file"));
        }
        if file.exists() && !self.replaces {
            let remedy = "choose another file, or replace this one (`force`)";
            return Err(Fault::data("already exists").in_file(file).with_remedy(remedy));
        }
        Ok(())
    }

    /// Fails if files of these names must not be written to this folder.
    pub fn check_folder(&self, folder: &Path, names: &[&str]) -> Result<(), Faults> {
        check_name(folder)?;
        let inputs = names.iter().map(|name| folder.join(name)).filter(|file| self.is_input(file));
        let faults = inputs.map(|file| input(&file).with_remedy("choose another folder (`out`)"));
        if let Some(faults) = Faults::of(faults.collect()) {
            return Err(faults);
        }
        let existing: Vec<&str> = names.iter().copied().filter(|name| folder.join(name).exists()).collect();
        if existing.is_empty() || self.replaces {
            return Ok(());
        }
        let fault = Fault::data(format!("already holds results: {}", existing.join(", "))).in_file(folder);
        Err(fault.with_remedy("choose another folder (`out`), or replace them (`force`)").into())
    }

    fn is_input(&self, file: &Path) -> bool {
        self.inputs.iter().any(|input| is_same(input, file))
    }
}

/// Fails if the system accepts no file or folder of this name: writing to it later would fail.
pub fn check_name(path: &Path) -> Result<(), Fault> {
    match path.symlink_metadata() {
        Err(error) if error.kind() == ErrorKind::InvalidFilename => {
            Err(Fault::from(error).while_writing(path))
        }
        _ => Ok(()),
    }
}

/// Whether a path is a folder or leads into it; the path need not exist.
pub fn is_within(path: &Path, folder: &Path) -> bool {
    let above = path.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
    match (fs::canonicalize(above), fs::canonicalize(folder)) {
        (Ok(above), Ok(folder)) => above.starts_with(folder),
        _ => false,
    }
}

fn input(file: &Path) -> Fault {
    Fault::data("is an input, and would be overwritten").in_file(file)
}

/// Whether two paths lead to the same file.
#[cfg(unix)]
fn is_same(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let [a, b] = [a, b].map(|path| fs::metadata(path).ok().map(|of| (of.dev(), of.ino())));
    a.is_some() && a == b
}

/// Whether two paths lead to the same file; hard links are not recognised.
#[cfg(not(unix))]
fn is_same(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(|path| fs::canonicalize(path).ok());
    a.is_some() && a == b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_input_is_recognised_under_any_name() {
        let folder = std::env::temp_dir().join(format!("nextview-keep-{}", std::process::id()));
        fs::create_dir_all(folder.join("in/deep")).unwrap();
        fs::create_dir_all(folder.join("out")).unwrap();
        let mesh = folder.join("in/mesh.ply");
        fs::write(&mesh, "mesh").unwrap();
        fs::hard_link(&mesh, folder.join("out/hard.ply")).unwrap();
        std::os::unix::fs::symlink("../in/mesh.ply", folder.join("out/soft.ply")).unwrap();
        std::os::unix::fs::symlink(folder.join("in"), folder.join("linked")).unwrap();
        fs::write(folder.join("out/other.ply"), "mesh").unwrap();
        let keeps = Overwrite::results().but(vec![mesh]);
        for name in ["in/mesh.ply", "in/deep/../mesh.ply", "out/hard.ply", "out/soft.ply", "linked/mesh.ply"]
        {
            let fault = keeps.check_file(&folder.join(name)).unwrap_err().to_string();
            assert!(fault.ends_with(&format!("{name}: is an input, and would be overwritten")), "{fault}");
        }
        for name in ["out/other.ply", "out/new.ply"] {
            keeps.check_file(&folder.join(name)).unwrap();
        }
        let faults = keeps.check_folder(&folder.join("out"), &["hard.ply", "other.ply", "soft.ply"]);
        assert_eq!(faults.unwrap_err().iter().count(), 2, "all inputs are named");
        fs::remove_dir_all(&folder).unwrap();
    }
}
