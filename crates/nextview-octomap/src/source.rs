use nextview::Error;
use std::io::{BufRead, BufReader, ErrorKind, Read};

/// Longest header line; OctoMap's own have 73 bytes. This keeps a file without line ends from filling the
/// memory.
const MAX_LINE: u64 = 4096;

/// A file read sequentially, with its position tracked for errors.
pub(crate) struct TrackedFile<R> {
    reader: BufReader<R>,
    n_lines: usize,
    position: u64,
}

impl<R: Read> TrackedFile<R> {
    pub fn new(reader: R) -> Self {
        Self { reader: BufReader::new(reader), n_lines: 0, position: 0 }
    }

    /// Returns the number of bytes read so far.
    pub fn position(&self) -> u64 {
        self.position
    }

    /// Reads the next line of text, without its end.
    pub fn line(&mut self) -> Result<String, Error> {
        let mut line = Vec::new();
        let n_bytes = self.reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)? as u64;
        self.n_lines += 1;
        self.position += n_bytes;
        if n_bytes == 0 {
            return Err(
                self.error_in_line("the file ends here, expected a header that ends with the line 'data'")
            );
        }
        if n_bytes == MAX_LINE && line.last() != Some(&b'\n') {
            return Err(
                self.error_in_line(format!("longer than {MAX_LINE} bytes, expected a line of the header"))
            );
        }
        Ok(String::from_utf8_lossy(&line).trim_end().to_string())
    }

    /// Fills the buffer. Returns false if the file ends before that.
    pub fn fill(&mut self, buffer: &mut [u8]) -> Result<bool, Error> {
        match self.reader.read_exact(buffer) {
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => return Ok(false),
            result => result?,
        }
        self.position += buffer.len() as u64;
        Ok(true)
    }

    /// Fails if there is more to read.
    pub fn expect_end(&mut self) -> Result<(), Error> {
        match self.fill(&mut [0])? {
            true => Err(error_at(self.position - 1, "the tree is complete, expected the file to end here")),
            false => Ok(()),
        }
    }

    /// Returns an error in the last line read.
    pub fn error_in_line(&self, problem: impl ToString) -> Error {
        Error::Format { place: format!("line {}", self.n_lines), problem: problem.to_string() }
    }
}

/// Returns an error at a byte offset from the file's start.
pub(crate) fn error_at(position: u64, problem: impl ToString) -> Error {
    Error::Format { place: format!("byte {position}"), problem: problem.to_string() }
}
