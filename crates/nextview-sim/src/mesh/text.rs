//! Reading the text formats line by line.

use crate::SimError;
use glam::DVec3;
use std::str::FromStr;

/// A non-blank line, with its number counted from 1.
pub(super) struct NumberedLine<'a> {
    pub number: usize,
    words: Vec<&'a [u8]>,
}

/// The lines of a [plain](nextview::text::plain) text, without comments (from `#` on) and blank lines. The
/// first line has the number `first_number`.
pub(super) fn lines(text: &[u8], first_number: usize) -> impl Iterator<Item = NumberedLine<'_>> {
    let lines = text.split(|&byte| byte == b'\n').zip(first_number..);
    lines
        .map(|(line, number)| NumberedLine { number, words: words(line) })
        .filter(|line| !line.words.is_empty())
}

/// The statements of a text in which a backslash at the end of a line continues it in the next one, as in OBJ
/// and MTL. A comment is not continued.
pub(super) fn statements(text: &[u8]) -> impl Iterator<Item = NumberedLine<'_>> {
    let mut lines = text.split(|&byte| byte == b'\n').zip(1..);
    let joined = std::iter::from_fn(move || {
        let (line, number) = lines.next()?;
        let mut all = words(line);
        while let Some(before) = all.last().and_then(|word| word.strip_suffix(b"\\")) {
            all.pop();
            all.extend(Some(before).filter(|word| !word.is_empty()));
            let Some((line, _)) = lines.next() else { break };
            all.extend(words(line));
        }
        Some(NumberedLine { number, words: all })
    });
    joined.filter(|line| !line.words.is_empty())
}

fn words(line: &[u8]) -> Vec<&[u8]> {
    let code = line.split(|&byte| byte == b'#').next().unwrap_or_default();
    code.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect()
}

impl<'a> NumberedLine<'a> {
    /// The line without one of these prefixes, in any case, which a number may follow directly; the result
    /// may be empty.
    pub fn without_prefix(mut self, prefixes: &[&[u8]]) -> Self {
        let n_letters = self.words[0].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let (letters, rest) = self.words[0].split_at(n_letters);
        let is_cut = rest.first().is_none_or(u8::is_ascii_digit);
        if is_cut && prefixes.iter().any(|prefix| letters.eq_ignore_ascii_case(prefix)) {
            match rest {
                [] => _ = self.words.remove(0),
                rest => self.words[0] = rest,
            }
        }
        self
    }

    /// Returns the words, at least one.
    pub fn words(&self) -> &[&'a [u8]] {
        &self.words
    }

    /// Whether the first word is this one, in any case.
    pub fn is(&self, keyword: &[u8]) -> bool {
        self.words[0].eq_ignore_ascii_case(keyword)
    }

    /// Returns the first word.
    pub fn keyword(&self) -> &'a [u8] {
        self.words[0]
    }

    /// Returns word `i` as a number.
    pub fn number<T: FromStr>(&self, i: usize, what: &str) -> Result<T, SimError> {
        let word = self.words.get(i).ok_or_else(|| {
            self.error(format!("has {} words, expected {what} as word {}", self.words.len(), i + 1))
        })?;
        let parsed = str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        parsed.ok_or_else(|| self.error(format!("{:?} is not {what}", shown(word))))
    }

    /// Returns three coordinates from word `i` on.
    pub fn point(&self, i: usize) -> Result<DVec3, SimError> {
        let coordinate = |k| self.number(i + k, "a coordinate");
        Ok(DVec3::new(coordinate(0)?, coordinate(1)?, coordinate(2)?))
    }

    /// Returns red, green and blue from word `i` on, 0 to 1 each.
    pub fn unit_color(&self, i: usize) -> Result<[f32; 3], SimError> {
        let share = |k| match self.number::<f32>(i + k, "a colour")? {
            share if (0.0..=1.0).contains(&share) => Ok(share),
            other => Err(self.error(format!("a colour is {other}, expected 0 to 1"))),
        };
        Ok([share(0)?, share(1)?, share(2)?])
    }

    /// Returns all words but the first.
    pub fn rest(&self) -> String {
        String::from_utf8_lossy(&self.words[1..].join(&b' ')).into_owned()
    }

    /// Returns an error at this line.
    pub fn error(&self, problem: impl Into<String>) -> SimError {
        SimError::format(format!("line {}", self.number), problem)
    }
}

/// The start of some bytes, fit for a message.
pub(super) fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned()
}
