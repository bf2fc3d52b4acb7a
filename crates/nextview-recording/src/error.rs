use std::path::{Path, PathBuf};

/// Errors in a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// An error in this file or folder; the source describes it.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The error.
        #[source]
        error: Box<RecordingError>,
    },
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The file cannot be written.
    #[error("cannot be written: {0}")]
    Unwritable(#[source] std::io::Error),
    /// A place in the file is invalid.
    #[error("{place}: {problem}")]
    Format {
        /// The line, byte offset or message.
        place: String,
        /// The fault, the value found and the expected content.
        problem: String,
    },
    /// The content as a whole is invalid or inconsistent.
    #[error("{0}")]
    Content(String),
    /// An option of [`ReadOptions`](crate::ReadOptions) does not fit the recording, or is missing.
    #[error("{problem} as `{key}`")]
    Option {
        /// The option.
        key: &'static str,
        /// The available values and the choice to make.
        problem: String,
    },
    /// A value is out of the library's range.
    #[error(transparent)]
    Value(#[from] nextview::Error),
}

impl RecordingError {
    pub(crate) fn format(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Format { place: place.into(), problem: problem.into() }
    }

    /// Attributes the error to this file.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        Self::InFile { path: path.to_owned(), error: Box::new(self) }
    }
}
