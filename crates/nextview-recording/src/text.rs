//! Text files: lines with content, their numbers, and errors that name the line.

use crate::{RecordingError, limits};
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// A line that is neither empty nor a comment.
#[derive(Clone, Copy)]
pub(crate) struct TextLine<'a> {
    /// Counted from 1.
    pub number: usize,
    /// The line without surrounding white space.
    pub text: &'a str,
}

/// Reads a file of UTF-8 text of bounded size and line length.
pub(crate) fn read(path: &Path) -> Result<String, RecordingError> {
    let text = nextview::text::utf8(limits::read(path, limits::MAX_TEXT)?)?;
    limits::check_lines(&text)?;
    limits::check_entries(lines(&text).count(), text.len() as u64)?;
    Ok(text)
}

/// The lines with content: empty ones and those that start with `#` are skipped.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = TextLine<'_>> {
    let lines = text.lines().enumerate().map(|(i, text)| TextLine { number: i + 1, text: text.trim() });
    lines.filter(|line| !line.text.is_empty() && !line.text.starts_with('#'))
}

impl<'a> TextLine<'a> {
    /// An error about this line.
    pub fn error(&self, problem: impl Into<String>) -> RecordingError {
        RecordingError::format(self.place(), problem)
    }

    /// Its place in the file.
    pub fn place(&self) -> String {
        format!("line {}", self.number)
    }

    /// The words separated by white space.
    pub fn words(&self) -> Vec<&'a str> {
        self.text.split_whitespace().collect()
    }

    /// The fields separated by commas.
    pub fn fields(&self) -> Vec<&'a str> {
        self.text.split(',').map(str::trim).collect()
    }

    /// Parses the value of a field of this name.
    pub fn value<T: FromStr>(&self, name: impl Display, text: &str) -> Result<T, RecordingError> {
        let kind = if T::from_str("0.5").is_ok() { "a number" } else { "a whole number of at least 0" };
        text.parse().map_err(|_| self.error(format!("{name} is '{text}', expected {kind}")))
    }
}
