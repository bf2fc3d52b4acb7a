//! Journals without a file, for `fuzz/` only.

use super::JournalEntry;
use super::read::{MAGIC, framed, read};

/// The entries of a journal with these contents, heading first, and valid checksums, followed by arbitrary
/// bytes; `None` if even the heading is unreadable.
pub fn entries<'a>(contents: impl IntoIterator<Item = &'a [u8]>, after: &[u8]) -> Option<Vec<JournalEntry>> {
    let mut bytes = MAGIC.to_vec();
    contents.into_iter().zip(0..).for_each(|(content, i)| bytes.extend(framed(i, content)));
    bytes.extend(after);
    let found = read(&bytes).ok()?;
    assert!(found.end <= bytes.len() && found.problem.is_none() == (found.end == bytes.len()));
    Some(found.entries)
}
