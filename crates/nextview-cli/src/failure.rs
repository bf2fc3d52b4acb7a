use nextview_recording::RecordingError;
use nextview_sim::SimError;
use std::fmt;
use std::path::Path;

/// Why a command failed, in words a user can act on.
#[derive(Debug)]
pub struct Failure {
    kind: Kind,
    message: String,
    hint: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Usage,
    Data,
}

impl Failure {
    /// The user asked for something that cannot be: exit code 2.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self { kind: Kind::Usage, message: message.to_string(), hint: None }
    }

    /// A file or the system is at fault: exit code 1.
    pub fn data(message: impl fmt::Display) -> Self {
        Self { kind: Kind::Data, message: message.to_string(), hint: None }
    }

    /// The same with a remedy.
    pub fn with_hint(mut self, hint: impl fmt::Display) -> Self {
        self.hint = Some(hint.to_string());
        self
    }

    /// The same, said of this file; whatever is wrong in a file is bad data.
    pub fn in_file(mut self, path: &Path) -> Self {
        self.message = format!("{}: {}", path.display(), self.message);
        self.kind = Kind::Data;
        self
    }

    /// The same, said of writing this file or folder.
    pub fn while_writing(mut self, path: &Path) -> Self {
        self.message = format!("cannot be written: {}", self.message);
        self.in_file(path).with_hint("does its folder exist, is it writable, and is there space on the disk?")
    }

    /// The same, said of a part of a file, which is to be named as well.
    pub fn within(mut self, part: impl fmt::Display) -> Self {
        self.message = format!("{part}: {}", self.message);
        self
    }

    /// What is wrong, without the remedy.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// 1 for bad data or a failing system, 2 for bad usage.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::Data => 1,
            Kind::Usage => 2,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.message)?;
        self.hint.iter().try_for_each(|hint| write!(f, "\nhint: {hint}"))
    }
}

impl From<nextview::Error> for Failure {
    fn from(error: nextview::Error) -> Self {
        match &error {
            nextview::Error::InvalidParameter { .. } | nextview::Error::TooLarge { .. } => Self::usage(error),
            _ => Self::data(error),
        }
    }
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Parameter(error) => error.into(),
            error => Self::data(error),
        }
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Self::data(error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::data(error)
    }
}
