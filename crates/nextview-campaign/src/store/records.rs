use super::RUNS;
use crate::RunRecord;
use nextview_scan::{Fault, FilePosition, files};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Maximum line length, bytes: the record of a scan of about 50,000 views.
const MAX_LINE: u64 = 1 << 26;

/// Minimum average number of bytes per JSON object in the text of a record. A step takes a thousand bytes in
/// memory, so many empty ones could fill it.
const OBJECT: usize = 64;

/// Number of JSON objects that a line may have regardless of its length.
const FREE_OBJECTS: usize = 100;

/// Bytes of lines parsed together, by all threads.
pub(super) const BATCH: usize = 1 << 22;

/// Records of a file, in the order in which the runs ended, including repeated ones.
#[derive(Debug)]
pub struct Records<R = BufReader<File>> {
    reader: R,
    path: PathBuf,
    /// Number of the file among others.
    file: u32,
    /// Number of lines read, and their bytes.
    n_lines: usize,
    n_bytes: u64,
    is_torn: bool,
    has_ended: bool,
    /// Records read ahead, by all threads.
    ready: VecDeque<Result<StoredRecord, Fault>>,
}

/// A record and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredRecord {
    /// Line in the file, from 1.
    pub line: usize,
    /// The record.
    pub record: RunRecord,
    pub(super) position: Position,
}

/// The place of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Position {
    /// Number of the file.
    pub file: u32,
    /// Line in the file, from 1.
    pub line: usize,
    /// First byte in the file.
    pub offset: u64,
    /// Length of the line in bytes without its line feed.
    pub n_bytes: u32,
}

/// Reads the records in a campaign's folder, even while the campaign runs.
pub fn records(dir: &Path) -> Result<Records, Fault> {
    let path = dir.join(RUNS);
    let reader =
        files::open(&path).map_err(|fault| fault.with_remedy("expected the folder of a campaign"))?;
    Ok(Records::new(reader, &path))
}

impl<R: BufRead> Records<R> {
    /// Reads the records of the file at this path from here on.
    pub(super) fn new(reader: R, path: &Path) -> Self {
        Self {
            reader,
            path: path.to_owned(),
            file: 0,
            n_lines: 0,
            n_bytes: 0,
            is_torn: false,
            has_ended: false,
            ready: VecDeque::new(),
        }
    }

    /// Sets the number of the file among others.
    pub(super) fn of_file(self, file: u32) -> Self {
        Self { file, ..self }
    }

    /// Returns whether the last line had no line feed and was left out; known once all records are read.
    pub fn is_torn(&self) -> bool {
        self.is_torn
    }

    /// Bytes of the complete lines; known once all records are read.
    pub(super) fn n_bytes(&self) -> u64 {
        self.n_bytes
    }

    /// Reads the next few lines and parses them.
    fn read_ahead(&mut self) {
        let (mut lines, mut n_bytes) = (Vec::new(), 0);
        let end = loop {
            if n_bytes >= BATCH {
                break None;
            }
            match self.read_line() {
                Ok(Some((position, line))) => {
                    n_bytes += line.len();
                    lines.push((position, line));
                }
                Ok(None) => break Some(None),
                Err(fault) => break Some(Some(fault)),
            }
        };
        self.has_ended = end.is_some();
        let path = &self.path;
        let parsed = |(position, line): &(Position, Vec<u8>)| {
            let record = parse(line, position.line, path)?;
            Ok(StoredRecord { line: position.line, record, position: *position })
        };
        self.ready = lines.par_iter().map(parsed).collect::<Vec<_>>().into();
        self.ready.extend(end.flatten().map(Err));
    }

    /// The next complete line without its line feed.
    fn read_line(&mut self) -> Result<Option<(Position, Vec<u8>)>, Fault> {
        let mut line = Vec::new();
        let read = self.reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line);
        let n_bytes = read.map_err(|error| Fault::from(error).in_file(&self.path))? as u64;
        // A file that an editor saved in another form must not pass for one with a torn line, which is cut.
        if !is_as_written(&line) {
            let fault =
                Fault::data("has a byte order mark or a carriage return, expected UTF-8 and only line feeds");
            let fault = fault.with_remedy("restore the original file");
            return Err(in_line(fault, self.n_lines + 1, &self.path));
        }
        if line.pop_if(|last| *last == b'\n').is_none() {
            if n_bytes == MAX_LINE {
                let fault =
                    Fault::data(format!("is longer than {MAX_LINE} bytes, expected the record of a run"));
                return Err(in_line(fault, self.n_lines + 1, &self.path));
            }
            self.is_torn = n_bytes > 0;
            return Ok(None);
        }
        self.n_lines += 1;
        let position = Position {
            file: self.file,
            line: self.n_lines,
            offset: self.n_bytes,
            // Lines have at most 2^26 bytes.
            n_bytes: line.len() as u32,
        };
        self.n_bytes += n_bytes;
        Ok(Some((position, line)))
    }
}

impl<R: BufRead> Iterator for Records<R> {
    type Item = Result<StoredRecord, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ready.is_empty() && !self.has_ended {
            self.read_ahead();
        }
        self.ready.pop_front()
    }
}

/// Whether a line has neither a byte order mark nor a carriage return other than one at its end.
fn is_as_written(line: &[u8]) -> bool {
    !line.starts_with("\u{feff}".as_bytes()) && !line.strip_suffix(b"\r\n").unwrap_or(line).contains(&b'\r')
}

/// The record in this line of a file.
pub(super) fn parse(text: &[u8], line: usize, path: &Path) -> Result<RunRecord, Fault> {
    let n_objects = text.iter().filter(|byte| **byte == b'{').count();
    if n_objects > FREE_OBJECTS + text.len() / OBJECT {
        let problem = format!("{n_objects} objects in {} bytes, expected the record of a run", text.len());
        return Err(in_line(Fault::data(problem), line, path));
    }
    parse_as(text, line, path)
}

/// A part of the record in this line of a file.
pub(super) fn parse_as<T: DeserializeOwned>(text: &[u8], line: usize, path: &Path) -> Result<T, Fault> {
    serde_json::from_slice(text).map_err(|error| malformed(&error, line, path))
}

fn malformed(error: &serde_json::Error, line: usize, path: &Path) -> Fault {
    // The error states its place in the given text, where it is always in the first line.
    let text = error.to_string();
    let problem = text.split(" at line ").next().unwrap_or_default();
    let place = FilePosition { file: path.to_owned(), position: Some((line, error.column().max(1))) };
    let fault = Fault::data(format!("{problem}, expected the record of a run"));
    Fault { place: Some(place), ..fault.with_remedy("was it written by another version of nextview?") }
}

/// A fault of the record in this line of a file.
pub(super) fn in_line(fault: Fault, line: usize, path: &Path) -> Fault {
    Fault { place: Some(FilePosition { file: path.to_owned(), position: Some((line, 1)) }), ..fault }
}
