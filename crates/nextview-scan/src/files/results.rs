use super::Overwrite;
use super::write::{unfinished, written_name};
use super::{create_folder, sync_folder};
use crate::{Fault, Faults};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A folder of results that appears as a whole or not at all. Its files are kept in memory until then.
#[derive(Debug)]
pub struct ResultFolder {
    target: PathBuf,
    /// The files and folders that it will contain.
    names: Vec<String>,
    rule: Overwrite,
    /// Where the files are written first, on the target's file system.
    staging: PathBuf,
    files: Vec<(String, Vec<u8>)>,
}

impl ResultFolder {
    /// Begins a folder of these files and folders. Fails immediately if it could not be written later, or if
    /// the rule forbids it.
    pub fn begin(target: &Path, names: &[&str], rule: Overwrite) -> Result<Self, Faults> {
        if target.exists() && !target.is_dir() {
            let fault = Fault::data("exists and is not a folder").in_file(target);
            return Err(fault.with_remedy("choose another folder (`out`)").into());
        }
        rule.check_folder(target, names)?;
        let staging = nearest_existing(target).join(unfinished(target));
        fs::create_dir(&staging)
            .and_then(|()| fs::remove_dir(&staging))
            .map_err(|e| Fault::from(e).while_writing(target))?;
        let names = names.iter().map(|&name| name.to_owned()).collect();
        Ok(Self { target: target.to_owned(), names, rule, staging, files: Vec::new() })
    }

    /// The path under which it is published.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Adds a file: one that the folder was begun with, or one inside such a folder, such as
    /// `frames/poses.csv`.
    pub fn add(
        &mut self,
        name: impl Into<String>,
        content: impl FnOnce(&mut Vec<u8>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let name = name.into();
        let entry = name.split('/').next().unwrap_or_default();
        assert!(self.names.iter().any(|name| name == entry), "{name} is none of {:?}", self.names);
        let mut bytes = Vec::new();
        content(&mut bytes)?;
        self.files.push((name, bytes));
        Ok(())
    }

    /// Publishes the finished folder under its name; it is on the disk on return. Fails if files have
    /// appeared there that the rule does not allow to replace.
    pub fn publish(self) -> Result<(), Faults> {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        self.rule.check_folder(&self.target, &names)?;
        let result = self.write().and_then(|()| {
            let moved = if self.target.exists() { self.move_entries() } else { self.move_folder() };
            moved.map_err(|e| Fault::from(e).while_writing(&self.target))
        });
        Ok(result.inspect_err(|_| {
            let _ = fs::remove_dir_all(&self.staging);
        })?)
    }

    fn write(&self) -> Result<(), Fault> {
        fs::create_dir(&self.staging).map_err(|e| Fault::from(e).while_writing(&self.target))?;
        for (name, bytes) in &self.files {
            let path = self.staging.join(name);
            let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
            let written = folder.and_then(|()| File::create(&path)).and_then(|mut file| {
                file.write_all(bytes)?;
                file.sync_all()
            });
            written.map_err(|e| Fault::from(e).while_writing(&self.target.join(name)))?;
        }
        self.sync().map_err(|e| Fault::from(e).while_writing(&self.target))
    }

    /// Syncs the folders of all files.
    fn sync(&self) -> io::Result<()> {
        let folders = self.files.iter().flat_map(|(name, _)| Path::new(name).ancestors().skip(1));
        let folders: BTreeSet<&Path> = folders.collect();
        folders.into_iter().try_for_each(|folder| sync_folder(&self.staging.join(folder).join("any")))
    }

    fn move_folder(&self) -> io::Result<()> {
        if let Some(parent) = self.target.parent() {
            create_folder(parent)?;
        }
        fs::rename(&self.staging, &self.target)?;
        sync_folder(&self.target)
    }

    fn move_entries(&self) -> io::Result<()> {
        for name in &self.names {
            let (new, old) = (self.staging.join(name), self.target.join(name));
            match (new.exists(), old.is_dir()) {
                (false, _) => continue,
                (true, true) => replace_folder(&new, &old)?,
                (true, false) => fs::rename(new, old)?,
            }
        }
        sync_folder(&self.target.join("any"))?;
        fs::remove_dir(&self.staging)
    }
}

/// A folder cannot be renamed over another one, so the old one is moved aside first.
fn replace_folder(new: &Path, old: &Path) -> io::Result<()> {
    let aside = new.with_extension("replaced");
    fs::rename(old, &aside)?;
    fs::rename(new, old)?;
    fs::remove_dir_all(aside)
}

/// Removes unfinished files and folders of these names, left in a folder by a killed process. No process may
/// be writing to them.
pub fn remove_unfinished(folder: &Path, names: &[&str]) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if !name.to_str().and_then(written_name).is_some_and(|name| names.contains(&name)) {
            continue;
        }
        let removed = entry.file_type().and_then(|kind| match kind.is_dir() {
            true => fs::remove_dir_all(entry.path()),
            false => fs::remove_file(entry.path()),
        });
        match removed {
            // Another process that begins here may have removed it.
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            removed => removed?,
        }
    }
    Ok(())
}

/// The path itself if it exists, otherwise its nearest existing parent.
fn nearest_existing(path: &Path) -> &Path {
    path.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    fn unfinished(path: &Path, rule: Overwrite) -> Result<ResultFolder, Faults> {
        let mut results = ResultFolder::begin(path, &["x", "y"], rule)?;
        results.add("x", |w| Ok(w.write_all(b"x")?))?;
        Ok(results)
    }

    #[test]
    fn a_folder_of_results_appears_as_a_whole() {
        let folder = std::env::temp_dir().join(format!("nextview-results-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("new/results");
        drop(unfinished(&path, Overwrite::nothing()));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "an unfinished folder leaves nothing");
        for rule in [Overwrite::nothing(), Overwrite::results()] {
            unfinished(&path, rule).unwrap().publish().unwrap();
            assert_eq!(fs::read(path.join("x")).unwrap(), b"x");
            assert_eq!(fs::read_dir(&path).unwrap().count(), 1);
        }
        assert_eq!(fs::read_dir(folder.join("new")).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_a_killed_process_left_of_stated_names_is_removed() {
        let folder = std::env::temp_dir().join(format!("nextview-remnants-{}", std::process::id()));
        fs::create_dir_all(folder.join(".out.7.partial/deep")).unwrap();
        let left = [".a.csv.12.partial", ".b.csv.12.partial", ".a.csv.partial", ".a.csv.x.partial", "a.csv"];
        left.iter().for_each(|name| fs::write(folder.join(name), "half").unwrap());
        remove_unfinished(&folder, &["a.csv", "out"]).unwrap();
        let names = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        assert_eq!(names, [".a.csv.partial", ".a.csv.x.partial", ".b.csv.12.partial", "a.csv"]);
        // Several writers at once.
        (0..200).for_each(|i| fs::write(folder.join(format!(".a.csv.{i}.partial")), "half").unwrap());
        (0..50).for_each(|i| fs::create_dir_all(folder.join(format!(".out.{i}.partial/deep"))).unwrap());
        let remove = || remove_unfinished(&folder, &["a.csv", "out"]).unwrap();
        thread::scope(|scope| (0..4).for_each(|_| _ = scope.spawn(remove)));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 4);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn folders_in_it_are_replaced_as_a_whole() {
        let folder = std::env::temp_dir().join(format!("nextview-nested-results-{}", std::process::id()));
        for names in [["in/deep/a", "in/b"], ["in/deep/c", "in/d"]] {
            let mut results = ResultFolder::begin(&folder, &["in"], Overwrite::results()).unwrap();
            names.iter().for_each(|name| results.add(*name, |w| Ok(w.write_all(b"x")?)).unwrap());
            results.publish().unwrap();
            assert_eq!(fs::read_dir(folder.join("in/deep")).unwrap().count(), 1);
            assert!(names.iter().all(|name| folder.join(name).is_file()));
            assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        }
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn files_that_are_there_or_have_appeared_stay() {
        let folder = std::env::temp_dir().join(format!("nextview-kept-results-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let begun = unfinished(&folder, Overwrite::nothing()).unwrap();
        fs::write(folder.join("y"), "mine").unwrap();
        for fault in [begun.publish().err(), unfinished(&folder, Overwrite::nothing()).err()] {
            let fault = fault.unwrap().to_string();
            assert!(fault.ends_with("already holds results: y"), "{fault}");
        }
        assert_eq!(fs::read(folder.join("y")).unwrap(), b"mine");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}
