use super::records::{BATCH, Position, parse, parse_as};
use crate::RunRecord;
use nextview_scan::{Fault, ScanConfig, files};
use rayon::prelude::*;
use serde::Deserialize;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Records of a campaign, each of a different run: stored in their files and read one after the other, as
/// often as needed, since those of a large campaign do not fit into memory.
#[derive(Clone, Debug, Default)]
pub struct RunRecords {
    files: Vec<PathBuf>,
    positions: Vec<Position>,
}

/// The part of a record with the run's configuration.
#[derive(Deserialize)]
struct Configured {
    config: ScanConfig,
}

impl RunRecords {
    pub(super) fn new(files: Vec<PathBuf>, positions: Vec<Position>) -> Self {
        Self { files, positions }
    }

    /// Returns the number of records.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns whether there are no records.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Iterates over the records. Fails if a file cannot be read or has changed.
    pub fn iter(&self) -> impl Iterator<Item = Result<RunRecord, Fault>> {
        self.parsed(parse)
    }

    /// The configurations only.
    pub(crate) fn configs(&self) -> impl Iterator<Item = Result<ScanConfig, Fault>> {
        self.parsed(|line, number, path| Ok(parse_as::<Configured>(line, number, path)?.config))
    }

    /// Parses each line, with the number of the line and the file, by all threads.
    fn parsed<T: Send>(
        &self,
        parse: impl Fn(&[u8], usize, &Path) -> Result<T, Fault> + Sync,
    ) -> impl Iterator<Item = Result<T, Fault>> {
        self.lines().flat_map(move |lines| match lines {
            Ok(lines) => {
                let parsed = |(position, line): &(Position, Vec<u8>)| {
                    parse(line, position.line, &self.files[position.file as usize])
                };
                lines.par_iter().map(parsed).collect::<Vec<_>>()
            }
            Err(fault) => vec![Err(fault)],
        })
    }

    /// The lines unchanged, without their line feeds, in batches.
    pub(super) fn lines(&self) -> Lines<'_> {
        Lines { files: &self.files, left: &self.positions, open: None }
    }
}

/// Reads lines at positions, in batches. Reading stops at the end of a line, so the next one needs no seek.
pub(super) struct Lines<'a> {
    files: &'a [PathBuf],
    left: &'a [Position],
    open: Option<OpenFile>,
}

/// A file and the position of its reader.
struct OpenFile {
    number: u32,
    reader: BufReader<File>,
    at: u64,
}

impl Iterator for Lines<'_> {
    type Item = Result<Vec<(Position, Vec<u8>)>, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let (mut lines, mut n_bytes) = (Vec::new(), 0);
        while let Some((&position, left)) = self.left.split_first().filter(|_| n_bytes < BATCH) {
            self.left = left;
            match line_at(self.files, position, &mut self.open) {
                Ok(line) => {
                    n_bytes += line.len();
                    lines.push((position, line));
                }
                Err(fault) => {
                    self.left = &[];
                    return Some(Err(fault));
                }
            }
        }
        (!lines.is_empty()).then(|| Ok(lines))
    }
}

/// The record at a position.
pub(super) fn read_at(files: &[PathBuf], position: Position) -> Result<RunRecord, Fault> {
    let line = line_at(files, position, &mut None)?;
    parse(&line, position.line, &files[position.file as usize])
}

fn line_at(files: &[PathBuf], position: Position, open: &mut Option<OpenFile>) -> Result<Vec<u8>, Fault> {
    let path = &files[position.file as usize];
    let mut file = match open.take().filter(|open| open.number == position.file) {
        Some(file) => file,
        None => OpenFile { number: position.file, reader: files::open(path)?, at: 0 },
    };
    let line = file.read(position).map_err(|error| Fault::from(error).in_file(path))?;
    *open = Some(file);
    Ok(line)
}

impl OpenFile {
    fn read(&mut self, position: Position) -> std::io::Result<Vec<u8>> {
        // Short distances stay within the buffer.
        match i64::try_from(position.offset.abs_diff(self.at)) {
            Ok(forward) if position.offset >= self.at => self.reader.seek_relative(forward)?,
            _ => drop(self.reader.seek(SeekFrom::Start(position.offset))?),
        }
        let mut line = vec![0; position.n_bytes as usize];
        self.reader.read_exact(&mut line)?;
        self.at = position.offset + u64::from(position.n_bytes);
        Ok(line)
    }
}
