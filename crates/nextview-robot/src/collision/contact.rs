use std::fmt;

/// Two things that are closer than allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contact {
    /// Name of a link or an attachment.
    pub part: String,
    /// Name of an obstacle, or of another link or attachment.
    pub other: String,
}

impl Contact {
    pub(super) fn new(part: &str, other: &str) -> Self {
        Self { part: part.to_owned(), other: other.to_owned() }
    }
}

impl fmt::Display for Contact {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} touches {}", self.part, self.other)
    }
}
