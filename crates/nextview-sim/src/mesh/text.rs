//! Reading the text formats line by line.

use crate::SimError;
use glam::DVec3;
use std::str::FromStr;

/// A line with content, with its number counted from 1.
pub(super) struct Line<'a> {
    pub number: usize,
    words: Vec<&'a [u8]>,
}

/// The lines of a text, without comments (from `#` on) and blank lines. The first has the number
/// `first_number`.
pub(super) fn lines(text: &[u8], first_number: usize) -> impl Iterator<Item = Line<'_>> {
    text.split(|&byte| byte == b'\n').enumerate().filter_map(move |(i, line)| {
        let code = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        let words: Vec<&[u8]> = code.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
        (!words.is_empty()).then_some(Line { number: first_number + i, words })
    })
}

impl<'a> Line<'a> {
    /// The words; never empty.
    pub fn words(&self) -> &[&'a [u8]] {
        &self.words
    }

    /// The first word.
    pub fn keyword(&self) -> &'a [u8] {
        self.words[0]
    }

    /// Word `i` as a number.
    pub fn number<T: FromStr>(&self, i: usize, what: &str) -> Result<T, SimError> {
        let word = self.words.get(i).ok_or_else(|| {
            self.error(format!("has {} words, expected {what} as word {}", self.words.len(), i + 1))
        })?;
        let parsed = str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        parsed.ok_or_else(|| self.error(format!("{:?} is not {what}", shown(word))))
    }

    /// Three coordinates from word `i` on.
    pub fn point(&self, i: usize) -> Result<DVec3, SimError> {
        let coordinate = |k| self.number(i + k, "a coordinate");
        Ok(DVec3::new(coordinate(0)?, coordinate(1)?, coordinate(2)?))
    }

    /// Red, green and blue from word `i` on, 0 to 1 each.
    pub fn unit_color(&self, i: usize) -> Result<[f32; 3], SimError> {
        let share = |k| match self.number::<f32>(i + k, "a colour")? {
            share if (0.0..=1.0).contains(&share) => Ok(share),
            other => Err(self.error(format!("a colour is {other}, expected 0 to 1"))),
        };
        Ok([share(0)?, share(1)?, share(2)?])
    }

    /// All words but the first.
    pub fn rest(&self) -> String {
        String::from_utf8_lossy(&self.words[1..].join(&b' ')).into_owned()
    }

    /// An error at this line.
    pub fn error(&self, problem: impl Into<String>) -> SimError {
        SimError::format(format!("line {}", self.number), problem)
    }
}

/// The start of some bytes, fit for a message.
pub(super) fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned()
}
