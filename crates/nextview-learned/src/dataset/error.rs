use super::DatasetConfig;
use nextview_sim::SimError;
use std::io;
use std::path::PathBuf;

/// The reason why a data set cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The folder holds a data set, and resuming was not requested.
    #[error("{}: already exists", path.display())]
    Exists {
        /// The configuration of that data set.
        path: PathBuf,
    },
    /// The folder holds another data set.
    #[error(
        "{}: the data set has objects = {}, seed = {}, for {}",
        path.display(), found.objects, found.seed, found.network
    )]
    Differs {
        /// The configuration of that data set.
        path: PathBuf,
        /// Its configuration.
        found: DatasetConfig,
    },
    /// The configuration in the folder cannot be read.
    #[error("{}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The error.
        problem: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        #[source]
        error: io::Error,
    },
    /// An object cannot be scanned.
    #[error(transparent)]
    Sim(#[from] SimError),
}
