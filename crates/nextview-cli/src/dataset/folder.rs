use super::{DatasetConfig, Sample, npy};
use crate::{Failure, files};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What decides the data set.
const CONFIG: &str = "dataset.toml";

/// The folder of a data set: what decides it, and files of samples, each of which is there as a whole or not at all.
pub(super) struct Folder(PathBuf);

impl Folder {
    /// Opens the folder for this data set, new or, if asked for, one with a part of the very same.
    pub fn open(dir: &Path, config: &DatasetConfig, resume: bool) -> Result<Self, Failure> {
        let path = dir.join(CONFIG);
        if path.exists() {
            check_same(&path, config, resume)?;
        } else {
            fs::create_dir_all(dir).map_err(|e| Failure::from(e).while_writing(dir))?;
            let text = toml::to_string(config).map_err(Failure::data)?;
            files::write(&path, |w| Ok(w.write_all(text.as_bytes())?))?;
        }
        Ok(Self(dir.to_owned()))
    }

    /// Whether the samples of this object and those after it are there.
    pub fn has(&self, first: u32) -> bool {
        self.file(first).exists()
    }

    /// Writes the samples of this object and those after it.
    pub fn write(&self, first: u32, samples: &[Sample]) -> Result<(), Failure> {
        files::write(&self.file(first), |writer| Ok(npy::write(writer, samples)?))
    }

    fn file(&self, first: u32) -> PathBuf {
        self.0.join(format!("objects-{first:07}.npy"))
    }
}

/// Fails unless the data set that is there may be gone on with.
fn check_same(path: &Path, config: &DatasetConfig, resume: bool) -> Result<(), Failure> {
    if !resume {
        let failure = Failure::data("is there already").in_file(path);
        return Err(failure.with_hint("pass --resume to go on with that data set, or another --out"));
    }
    let text = fs::read_to_string(path).map_err(|e| Failure::from(e).in_file(path))?;
    let found: DatasetConfig =
        toml::from_str(&text).map_err(|e| Failure::data(e.to_string().trim_end()).in_file(path))?;
    if found == *config {
        return Ok(());
    }
    let DatasetConfig { objects, seed } = found;
    let failure = Failure::data(format!("the data set has {objects} objects and seed {seed}")).in_file(path);
    Err(failure.with_hint(format!("pass --objects {objects} --seed {seed}, or another --out")))
}
