//! The layout of a journal: consecutive entries with checksums.

use super::entry::{read_entry, read_heading};
use super::kept::JournalEntry;
use crate::Fault;

/// The first bytes of a journal.
pub(super) const MAGIC: &[u8; 8] = b"nvframes";

/// Bytes before each entry: its length and its checksum.
const FRAMING: usize = 8;

/// The bytes of an entry: length, checksum of its number and its content, content.
pub(super) fn framed(number: u64, payload: &[u8]) -> Vec<u8> {
    let length = u32::try_from(payload.len()).expect("an image of at most 2^30 pixels, compressed");
    let mut bytes = Vec::with_capacity(FRAMING + payload.len());
    bytes.extend(length.to_le_bytes());
    bytes.extend(checksum(number, payload).to_le_bytes());
    bytes.extend(payload);
    bytes
}

/// The undamaged part of a journal.
pub(super) struct ReadJournal {
    pub heading: String,
    pub entries: Vec<JournalEntry>,
    /// Offset in bytes of the end of this part.
    pub end: usize,
    /// The fault at that offset; `None` if it is the end of the file.
    pub problem: Option<String>,
}

/// Reads up to the first damaged entry, which must not be the heading.
pub(super) fn read(bytes: &[u8]) -> Result<ReadJournal, Fault> {
    if !bytes.starts_with(MAGIC) {
        return Err(Fault::data("is not the journal of a scan: it does not begin with nvframes"));
    }
    let mut at = MAGIC.len();
    let heading = next(bytes, at, 0).and_then(|payload| Ok((payload.len(), read_heading(payload)?)));
    let (length, heading) = heading.map_err(|problem| Fault::data(format!("byte {at}: {problem}")))?;
    at += FRAMING + length;
    let mut found = ReadJournal { heading, entries: Vec::new(), end: at, problem: None };
    while found.end < bytes.len() {
        let number = 1 + found.entries.len() as u64;
        let entry =
            next(bytes, found.end, number).and_then(|payload| Ok((payload.len(), read_entry(payload)?)));
        match entry {
            Ok((length, entry)) => {
                found.entries.push(entry);
                found.end += FRAMING + length;
            }
            Err(problem) => {
                found.problem = Some(problem);
                break;
            }
        }
    }
    Ok(found)
}

/// The content of the entry at this offset.
fn next(bytes: &[u8], at: usize, number: u64) -> Result<&[u8], String> {
    let rest = &bytes[at..];
    let Some((framing, rest)) = rest.split_at_checked(FRAMING) else {
        return Err(format!("an entry begins with {FRAMING} bytes, but {} are left", rest.len()));
    };
    let word = |i: usize| u32::from_le_bytes(framing[i..i + 4].try_into().expect("four bytes"));
    let (length, expected) = (word(0) as usize, word(4));
    let Some(payload) = rest.get(..length) else {
        return Err(format!("an entry of {length} bytes, but {} are left", rest.len()));
    };
    let actual = checksum(number, payload);
    if actual == expected {
        Ok(payload)
    } else {
        Err(format!("the checksum is {actual:08x}, expected {expected:08x}"))
    }
}

/// Includes the number, which makes swapped entries detectable.
fn checksum(number: u64, payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&number.to_le_bytes());
    hasher.update(payload);
    hasher.finalize()
}
