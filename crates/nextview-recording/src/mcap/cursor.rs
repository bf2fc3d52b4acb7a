use crate::RecordingError;

/// Maximum length of the name of a topic, a type or an encoding, in bytes: each message is named by its
/// topic.
const MAX_NAME: u32 = 256;

/// Reads bytes from front to back and never past the end.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Number of bytes read.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The unread bytes.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Reads the next `n` bytes.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8], RecordingError> {
        let Some(taken) = self.rest().get(..n) else {
            let problem = format!("{n} bytes expected, but only {} are left", self.rest().len());
            return Err(RecordingError::format(format!("byte {}", self.at), problem));
        };
        self.at += n;
        Ok(taken)
    }

    /// Reads the next `N` bytes.
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], RecordingError> {
        Ok(self.take(N)?.try_into().expect("as many were taken"))
    }

    /// Reads a text, preceded by its length.
    pub fn text(&mut self) -> Result<&'a str, RecordingError> {
        let length = u32::from_le_bytes(self.array()?);
        if length > MAX_NAME {
            let problem = format!("a name has {length} bytes, expected at most {MAX_NAME}");
            return Err(RecordingError::Content(problem));
        }
        str::from_utf8(self.take(length as usize)?)
            .map_err(|_| RecordingError::Content("a name is not UTF-8".into()))
    }
}
