use super::RUNS;
use crate::RunRecord;
use nextview_scan::{Fault, Place, files};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Longest line, bytes: the record of a scan of about 50,000 views.
const MAX_LINE: u64 = 1 << 26;

/// Fewest bytes of an object in the text of a record, on average. In memory a step takes a thousand, so that
/// empty ones could fill it.
const OBJECT: usize = 64;

/// Objects that a line of any length may have.
const FREE_OBJECTS: usize = 100;

/// Records of a file, one after the other in the order in which the runs ended; repeated ones as they stand.
#[derive(Debug)]
pub struct Records<R = BufReader<File>> {
    reader: R,
    path: PathBuf,
    /// Lines read so far, and their bytes.
    n_lines: usize,
    n_bytes: u64,
    is_torn: bool,
}

/// A record and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredRecord {
    /// Line in the file, from 1.
    pub line: usize,
    /// The record.
    pub record: RunRecord,
}

/// The records in a campaign's folder, also while the campaign runs.
pub fn records(dir: &Path) -> Result<Records, Fault> {
    let path = dir.join(RUNS);
    let reader =
        files::open(&path).map_err(|fault| fault.with_remedy("expected the folder of a campaign"))?;
    Ok(Records::new(reader, &path))
}

impl<R: BufRead> Records<R> {
    /// What this reader gives from here on, of the file at this path.
    pub(super) fn new(reader: R, path: &Path) -> Self {
        Self { reader, path: path.to_owned(), n_lines: 0, n_bytes: 0, is_torn: false }
    }

    /// Whether the last line had no line feed and was left out; known at the end.
    pub fn is_torn(&self) -> bool {
        self.is_torn
    }

    /// Bytes of the whole lines read so far.
    pub(super) fn n_bytes(&self) -> u64 {
        self.n_bytes
    }

    fn parse(&self, line: &[u8]) -> Result<StoredRecord, Fault> {
        let n_objects = line.iter().filter(|byte| **byte == b'{').count();
        if n_objects > FREE_OBJECTS + line.len() / OBJECT {
            let problem =
                format!("{n_objects} objects in {} bytes, expected the record of a run", line.len());
            return Err(in_line(Fault::data(problem), self.n_lines, &self.path));
        }
        let parsed = serde_json::from_slice(line);
        let record = parsed.map_err(|error| malformed(&error, self.n_lines, &self.path))?;
        Ok(StoredRecord { line: self.n_lines, record })
    }
}

impl<R: BufRead> Iterator for Records<R> {
    type Item = Result<StoredRecord, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut line = Vec::new();
        let n_bytes = match self.reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line) {
            Ok(0) => return None,
            Ok(n_bytes) => n_bytes as u64,
            Err(e) => return Some(Err(Fault::from(e).in_file(&self.path))),
        };
        let Some(whole) = line.strip_suffix(b"\n") else {
            if n_bytes == MAX_LINE {
                let fault =
                    Fault::data(format!("is longer than {MAX_LINE} bytes, expected the record of a run"));
                return Some(Err(in_line(fault, self.n_lines + 1, &self.path)));
            }
            self.is_torn = true;
            return None;
        };
        self.n_lines += 1;
        self.n_bytes += n_bytes;
        Some(self.parse(whole))
    }
}

fn malformed(error: &serde_json::Error, line: usize, path: &Path) -> Fault {
    // The error names its place in the text it was given, which is always the first line of one.
    let text = error.to_string();
    let problem = text.split(" at line ").next().unwrap_or_default();
    let place = Place { file: path.to_owned(), position: Some((line, error.column().max(1))) };
    let fault = Fault::data(format!("{problem}, expected the record of a run"));
    Fault { place: Some(place), ..fault.with_remedy("was it written by another version of nextview?") }
}

/// A fault of the record in this line of a file.
pub(super) fn in_line(fault: Fault, line: usize, path: &Path) -> Fault {
    Fault { place: Some(Place { file: path.to_owned(), position: Some((line, 1)) }), ..fault }
}
