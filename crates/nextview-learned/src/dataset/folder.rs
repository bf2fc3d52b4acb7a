use super::error::DatasetError;
use super::npy;
use super::sample::TrainingSample;
use super::{DatasetConfig, NetworkName};
use nextview::text;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The file of the configuration.
const CONFIG: &str = "dataset.toml";

/// The folder of a data set: its configuration, and files of samples, each of which is complete or absent.
pub(super) struct Folder(PathBuf);

impl Folder {
    /// Opens the folder for this data set: a new one or, with `resume`, one with a part of the same data set.
    pub fn open(dir: &Path, config: &DatasetConfig, resume: bool) -> Result<Self, DatasetError> {
        let path = dir.join(CONFIG);
        if path.exists() {
            check_same(&path, config, resume)?;
        } else {
            fs::create_dir_all(dir).map_err(|error| failed(dir, error))?;
            let text = toml::to_string(config).expect("a name and two numbers");
            replace(&path, |writer| writer.write_all(text.as_bytes()))?;
        }
        Ok(Self(dir.to_owned()))
    }

    /// Returns whether the samples of the file that starts with this object exist.
    pub fn has(&self, first: u32) -> bool {
        self.file(first).exists()
    }

    /// Writes the samples of the file that starts with this object.
    pub fn write(
        &self,
        first: u32,
        network: NetworkName,
        samples: &[TrainingSample],
    ) -> Result<(), DatasetError> {
        replace(&self.file(first), |writer| npy::write(writer, network, samples))
    }

    fn file(&self, first: u32) -> PathBuf {
        self.0.join(format!("objects-{first:07}.npy"))
    }
}

/// Fails unless the existing data set may be resumed.
fn check_same(path: &Path, config: &DatasetConfig, resume: bool) -> Result<(), DatasetError> {
    if !resume {
        return Err(DatasetError::Exists { path: path.to_owned() });
    }
    // A pipe may never end.
    let read = || match path.is_file() {
        true => fs::read(path).and_then(|bytes| text::utf8(bytes).map_err(io::Error::other)),
        false => Err(io::Error::other("it is not a regular file")),
    };
    let text = read().map_err(|error| failed(path, error))?;
    let malformed = |error: toml::de::Error| DatasetError::Malformed {
        path: path.to_owned(),
        problem: error.to_string().trim_end().to_owned(),
    };
    let found: DatasetConfig = toml::from_str(&text).map_err(malformed)?;
    if found == *config {
        return Ok(());
    }
    Err(DatasetError::Differs { path: path.to_owned(), found })
}

/// Writes a temporary file next to the target, synced to disk, and then renames it.
fn replace(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), DatasetError> {
    let beside = path.with_extension("partial");
    let whole = || {
        let mut writer = BufWriter::new(File::create(&beside)?);
        content(&mut writer)?;
        writer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        fs::rename(&beside, path)
    };
    whole().map_err(|error| {
        // The first error is reported; the temporary file may not even exist.
        let _ = fs::remove_file(&beside);
        failed(path, error)
    })
}

fn failed(path: &Path, error: io::Error) -> DatasetError {
    DatasetError::Io { path: path.to_owned(), error }
}
