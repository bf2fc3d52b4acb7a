//! Faults as data; front ends word them for their users.

use nextview_recording::RecordingError;
use serde::Serialize;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A fault with the value at fault and the expected value.
///
/// Keys of the configuration are in backticks in `message` and `remedy`: front ends replace them by their own
/// names, such as a program's flags or the keys of a server's requests.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// Who can correct it.
    pub kind: FaultKind,
    /// Where the fault is, if it is in a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<FilePosition>,
    /// Dotted key of the configuration, such as `max_flow.gamma`; `None` if it is not about one value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
    /// The given value, as text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// The expected range or kind of value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
    /// The whole fault as a sentence, including value and expectation but not its place.
    pub message: String,
    /// The remedy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// The underlying error, if an external planner failed.
    #[serde(skip)]
    pub cause: Option<Cause>,
}

/// The error behind a fault. Two are equal if they are the same instance.
#[derive(Clone, Debug)]
pub struct Cause(pub Arc<dyn std::error::Error + Send + Sync>);

impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for Cause {}

/// Who can correct a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// The caller: a value or a combination of values is invalid.
    Request,
    /// A file or the system is at fault.
    Data,
    /// Nobody: a computation was cancelled, and can be repeated.
    Cancelled,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FilePosition {
    /// The file or folder.
    pub file: PathBuf,
    /// Line and column, counted from 1; `None` for the whole file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<(usize, usize)>,
}

impl Fault {
    /// An invalid request.
    pub fn request(message: impl fmt::Display) -> Self {
        Self::new(FaultKind::Request, message)
    }

    /// A file or the system is at fault.
    pub fn data(message: impl fmt::Display) -> Self {
        Self::new(FaultKind::Data, message)
    }

    /// The value of a key is out of its range.
    pub fn of_value(key: &str, value: impl fmt::Display, expected: impl fmt::Display) -> Self {
        let fault = Self::request(format!("`{key}` is {value}, expected {expected}"));
        let (value, expected) = (Some(value.to_string()), Some(expected.to_string()));
        Self { key: Some(key.to_owned()), value, expected, ..fault }
    }

    fn new(kind: FaultKind, message: impl fmt::Display) -> Self {
        let message = message.to_string();
        Self { kind, place: None, key: None, value: None, expected: None, message, remedy: None, cause: None }
    }

    /// Sets the remedy.
    pub fn with_remedy(mut self, remedy: impl fmt::Display) -> Self {
        self.remedy = Some(remedy.to_string());
        self
    }

    /// Sets the underlying error.
    pub fn with_cause(mut self, cause: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        self.cause = Some(Cause(cause.into().into()));
        self
    }

    /// Sets the file, which makes it a fault of data. An inner place stays.
    pub fn in_file(mut self, file: &Path) -> Self {
        self.place.get_or_insert_with(|| FilePosition { file: file.to_owned(), position: None });
        self.kind = FaultKind::Data;
        self
    }

    /// Marks the fault as one of writing this file or folder. A remedy stays.
    pub fn while_writing(mut self, file: &Path) -> Self {
        self.message = format!("cannot be written: {}", self.message);
        let fault = self.in_file(file);
        match fault.remedy {
            Some(_) => fault,
            None => {
                fault.with_remedy("does its folder exist, is it writable, and is there space on the disk?")
            }
        }
    }

    /// A fault of the library, with its key prefixed by a section of the configuration.
    pub(crate) fn of_part(section: &str, error: nextview::Error) -> Self {
        match error {
            nextview::Error::InvalidParameter { name, value, expected } => {
                Self::of_value(&format!("{section}.{name}"), value, expected)
            }
            error => Self::from(error).within(section),
        }
    }

    /// Places the fault in a named part of a file.
    pub fn within(mut self, part: impl fmt::Display) -> Self {
        self.message = format!("{part}: {}", self.message);
        self
    }
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        self.position.map_or(Ok(()), |(line, column)| write!(f, ", line {line}, column {column}"))
    }
}

impl fmt::Display for Fault {
    /// Writes place and message; front ends write the remedy.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "{place}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for Fault {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.cause.as_ref().map(|cause| &*cause.0 as _)
    }
}

impl From<nextview::Error> for Fault {
    fn from(error: nextview::Error) -> Self {
        let message = error.to_string();
        match error {
            nextview::Error::InvalidParameter { name, value, expected } => {
                Self { message, ..Self::of_value(name, value, expected) }
            }
            nextview::Error::UnreachableGoal { goal_mm, best_mm, distance } => {
                let expected = format!("at least {best_mm}: three looks of this camera from {distance} m");
                Self::of_value("goal_mm", goal_mm, expected)
            }
            nextview::Error::TooLarge { .. } => Self::request(message),
            nextview::Error::Planner(cause) => Self::request(message).with_cause(cause),
            nextview::Error::Cancelled(cancelled) => cancelled.into(),
            _ => Self::data(message),
        }
    }
}

impl From<nextview::Cancelled> for Fault {
    fn from(cancelled: nextview::Cancelled) -> Self {
        Self::new(FaultKind::Cancelled, cancelled)
    }
}

#[cfg(feature = "simulated")]
impl From<nextview_sim::SimError> for Fault {
    fn from(error: nextview_sim::SimError) -> Self {
        match error {
            nextview_sim::SimError::Parameter(error) => error.into(),
            error => Self::data(error),
        }
    }
}

impl From<RecordingError> for Fault {
    fn from(error: RecordingError) -> Self {
        match error {
            RecordingError::InFile { path, error } => Self::from(*error).within(path.display()),
            // The options of the recording library are keys of `recording.read` here.
            RecordingError::Option { key, problem } => {
                let key = format!("recording.read.{key}");
                Self { key: Some(key.clone()), ..Self::data(format!("{problem} as `{key}`")) }
            }
            error => Self::data(error),
        }
    }
}

/// The error number EMFILE on Unix.
#[cfg(unix)]
const TOO_MANY_FILES: i32 = 24;

impl From<std::io::Error> for Fault {
    fn from(error: std::io::Error) -> Self {
        let remedy = match (error.kind(), error.raw_os_error()) {
            (ErrorKind::InvalidFilename, _) => Some("a name has at most 255 bytes"),
            (ErrorKind::StorageFull | ErrorKind::QuotaExceeded, _) => Some("free some space on the disk"),
            (ErrorKind::FileTooLarge, _) => Some("the system limits the size of files (ulimit -f)"),
            (ErrorKind::OutOfMemory, _) => Some("the system limits the memory (ulimit -v)"),
            #[cfg(unix)]
            (_, Some(TOO_MANY_FILES)) => Some("the system limits the number of open files (ulimit -n)"),
            _ => None,
        };
        Self { remedy: remedy.map(str::to_owned), ..Self::data(error) }
    }
}

/// All faults found: at least one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Faults(Vec<Fault>);

impl Faults {
    /// Wraps these faults; `None` if there are none.
    pub fn of(faults: Vec<Fault>) -> Option<Self> {
        (!faults.is_empty()).then_some(Self(faults))
    }

    /// Iterates over the faults, at least one.
    pub fn iter(&self) -> std::slice::Iter<'_, Fault> {
        self.0.iter()
    }

    /// Applies a change to each fault.
    pub fn map(self, change: impl FnMut(Fault) -> Fault) -> Self {
        Self(self.0.into_iter().map(change).collect())
    }

    /// Sets the file of each fault.
    pub fn in_file(self, file: &Path) -> Self {
        self.map(|fault| fault.in_file(file))
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Self(vec![fault])
    }
}

impl fmt::Display for Faults {
    /// Writes one fault per line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.0.iter().enumerate() {
            write!(f, "{}{fault}", if i > 0 { "\n" } else { "" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

macro_rules! faults_from {
    ($($error:ty),*) => { $(
        impl From<$error> for Faults {
            fn from(error: $error) -> Self {
                Fault::from(error).into()
            }
        }
    )* };
}
faults_from!(nextview::Error, nextview::Cancelled, RecordingError, std::io::Error);
#[cfg(feature = "simulated")]
faults_from!(nextview_sim::SimError);
