//! The container: consecutive records in a file, most of them in compressed chunks (mcap.dev/spec).
//!
//! Our own reader: the crate `mcap` takes 26 s of CPU time to build with its dependencies, decompresses with
//! C code, and requires the whole file in memory. We need only four kinds of records.

use super::chunk;
use super::cursor::Cursor;
use crate::{RecordingError, limits};
use crc32fast::Hasher;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Position of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RecordPosition {
    /// Offset in the file of the record, or of the chunk that contains it.
    byte: u64,
    /// Offset among the chunk's records, if in a chunk.
    in_chunk: Option<usize>,
    /// Size of the record, or of the chunk's records.
    pub(crate) n_bytes: usize,
    /// Checksum of the message: the file may change before it is read again.
    crc: u32,
}

/// The records that concern messages.
#[derive(Debug)]
pub(super) enum Record<'a> {
    Schema { id: u16, name: &'a str },
    Channel { id: u16, schema: u16, topic: &'a str, encoding: &'a str },
    Message { channel: u16, data: &'a [u8] },
}

/// An open file, read from record to record.
struct RecordReader {
    file: BufReader<File>,
    /// Offset of the next record, and the size of the file.
    byte: u64,
    size: u64,
    /// Checksum of everything read since a certain record.
    crc: Hasher,
}

/// Values of the first byte of a record.
mod opcode {
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const FOOTER: u8 = 0x02;
    pub const STATISTICS: u8 = 0x0b;
    pub const DATA_END: u8 = 0x0f;
}

/// Visits every schema, channel and message, in file order, until the end of the data. Also fails at the end
/// if the data contradicts its checksum or the file's summary.
pub(super) fn walk(
    path: &Path,
    mut visit: impl FnMut(RecordPosition, Record<'_>) -> Result<(), RecordingError>,
) -> Result<(), RecordingError> {
    let mut records = RecordReader::open(path)?;
    let (mut n_plain, mut n_messages) = (0, 0);
    let mut show = |place, opcode, content: &[u8]| {
        n_messages += u64::from(opcode == opcode::MESSAGE);
        parse(opcode, content)?.map_or(Ok(()), |record| visit(place, record))
    };
    loop {
        let byte = records.byte;
        let crc = records.crc.clone();
        let (opcode, content) = records.next()?;
        let in_record = |error| at(byte, error);
        match opcode {
            opcode::DATA_END => {
                let stated = Cursor::new(&content).array().map(u32::from_le_bytes).map_err(in_record)?;
                check_sum("the file's data", stated, crc).map_err(in_record)?;
                return check_summary(&mut records, n_messages);
            }
            opcode::CHUNK => {
                let plain = chunk::records(&content).map_err(in_record)?;
                n_plain += plain.len() as u64;
                limits::check_chunks(n_plain, records.size).map_err(in_record)?;
                let mut cursor = Cursor::new(&plain);
                while !cursor.rest().is_empty() {
                    let in_chunk = Some(cursor.at());
                    let (opcode, content) = next_in_chunk(&mut cursor).map_err(in_record)?;
                    let place = RecordPosition {
                        byte,
                        in_chunk,
                        n_bytes: plain.len(),
                        crc: crc32fast::hash(content),
                    };
                    show(place, opcode, content).map_err(in_record)?;
                }
            }
            opcode => {
                let crc = crc32fast::hash(&content);
                let place = RecordPosition { byte, in_chunk: None, n_bytes: content.len(), crc };
                show(place, opcode, &content).map_err(in_record)?;
            }
        }
    }
}

/// Fails if the file states another checksum for these bytes; 0 stands for none.
fn check_sum(what: &str, stated: u32, of_bytes: Hasher) -> Result<(), RecordingError> {
    let found = of_bytes.finalize();
    if stated == 0 || stated == found {
        return Ok(());
    }
    let problem = format!("{what} is damaged: its checksum is {found:08x}, expected {stated:08x}");
    Err(RecordingError::Content(problem))
}

/// Reads everything after the data. A file without a whole summary is accepted, because its data may be
/// whole.
fn check_summary(records: &mut RecordReader, n_messages: u64) -> Result<(), RecordingError> {
    let start = records.byte;
    records.crc = Hasher::new();
    let mut counted = None;
    loop {
        let byte = records.byte;
        let mut crc = records.crc.clone();
        let (opcode, content) = match records.next() {
            Err(error @ RecordingError::Io(_)) => return Err(error),
            Err(_) => return Ok(()),
            Ok(record) => record,
        };
        match opcode {
            opcode::STATISTICS => counted = content.first_chunk().map(|count| u64::from_le_bytes(*count)),
            opcode::FOOTER => {
                let mut cursor = Cursor::new(&content);
                let mut number = || cursor.array().map(u64::from_le_bytes);
                let (Ok(summary_start), Ok(_)) = (number(), number()) else { return Ok(()) };
                let Ok(stated) = cursor.array().map(u32::from_le_bytes) else { return Ok(()) };
                if summary_start != start {
                    return Ok(());
                }
                crc.update(&[opcode]);
                crc.update(&(content.len() as u64).to_le_bytes());
                crc.update(&content[..cursor.at() - 4]);
                check_sum("the file's summary", stated, crc).map_err(|error| at(byte, error))?;
                break;
            }
            _ => {}
        }
    }
    match counted {
        Some(counted) if counted != n_messages => Err(RecordingError::Content(format!(
            "the file is damaged: it holds {n_messages} messages, but its summary counts {counted}; `mcap \
             recover` keeps the intact part"
        ))),
        _ => Ok(()),
    }
}

/// Reads the message that [`walk`] found at this place. Fails if it has changed.
pub(super) fn message(path: &Path, place: RecordPosition) -> Result<Vec<u8>, RecordingError> {
    let mut records = RecordReader::open(path)?;
    records.byte = place.byte;
    records.file.seek(SeekFrom::Start(place.byte))?;
    let (opcode, content) = records.next()?;
    let read = || match (opcode, place.in_chunk) {
        (opcode::CHUNK, Some(offset)) => {
            let plain = chunk::records(&content)?;
            let mut cursor = Cursor::new(&plain);
            cursor.take(offset)?;
            let (opcode, content) = next_in_chunk(&mut cursor)?;
            data(opcode, content, place.crc)
        }
        (opcode, _) => data(opcode, &content, place.crc),
    };
    read().map_err(|error| at(place.byte, error))
}

fn data(opcode: u8, content: &[u8], crc: u32) -> Result<Vec<u8>, RecordingError> {
    match parse(opcode, content)? {
        Some(Record::Message { data, .. }) if crc32fast::hash(content) == crc => Ok(data.to_vec()),
        _ => Err(RecordingError::Content("the file has changed since it was opened".into())),
    }
}

/// Parses a record; `None` if its kind is not needed here.
fn parse(opcode: u8, content: &[u8]) -> Result<Option<Record<'_>>, RecordingError> {
    let mut cursor = Cursor::new(content);
    Ok(Some(match opcode {
        opcode::SCHEMA => Record::Schema { id: short(&mut cursor)?, name: cursor.text()? },
        opcode::CHANNEL => Record::Channel {
            id: short(&mut cursor)?,
            schema: short(&mut cursor)?,
            topic: cursor.text()?,
            encoding: cursor.text()?,
        },
        opcode::MESSAGE => {
            let channel = short(&mut cursor)?;
            cursor.take(4 + 8 + 8)?; // number, and times of logging and publishing
            Record::Message { channel, data: cursor.rest() }
        }
        _ => return Ok(None),
    }))
}

fn next_in_chunk<'a>(cursor: &mut Cursor<'a>) -> Result<(u8, &'a [u8]), RecordingError> {
    let [opcode] = cursor.array()?;
    let length = u64::from_le_bytes(cursor.array()?);
    Ok((opcode, cursor.take(usize::try_from(length).unwrap_or(usize::MAX))?))
}

fn short(cursor: &mut Cursor<'_>) -> Result<u16, RecordingError> {
    Ok(u16::from_le_bytes(cursor.array()?))
}

impl RecordReader {
    fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = limits::open(path)?;
        let size = file.metadata()?.len();
        let (file, byte) = (BufReader::new(file), MAGIC.len() as u64);
        let mut records =
            Self { file, byte, size, crc: Hasher::new_with_initial_len(crc32fast::hash(&MAGIC), byte) };
        let mut magic = [0; MAGIC.len()];
        match records.file.read_exact(&mut magic) {
            Ok(()) if magic == MAGIC => Ok(records),
            Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(error.into()),
            _ => Err(RecordingError::Content(
                "is not an MCAP file: it does not begin with the magic bytes of MCAP".into(),
            )),
        }
    }

    /// Reads kind and content of the next record.
    fn next(&mut self) -> Result<(u8, Vec<u8>), RecordingError> {
        const HEAD: u64 = 9;
        let left = self.size.saturating_sub(self.byte);
        let mut head = [0; HEAD as usize];
        if left < HEAD {
            return Err(self.cut());
        }
        self.file.read_exact(&mut head)?;
        let [opcode, length @ ..] = head;
        let length = u64::from_le_bytes(length);
        if length > left - HEAD {
            return Err(self.cut());
        }
        // Limited to the size of the file, whatever the record states.
        let mut content = vec![0; length as usize];
        self.file.read_exact(&mut content)?;
        self.crc.update(&head);
        self.crc.update(&content);
        self.byte += HEAD + length;
        Ok((opcode, content))
    }

    fn cut(&self) -> RecordingError {
        let problem = format!(
            "the file ends inside a record after {} bytes: was the recorder stopped, or the copy incomplete? \
             `mcap recover` keeps the intact part",
            self.size
        );
        RecordingError::format(format!("byte {}", self.byte), problem)
    }
}

fn at(byte: u64, error: RecordingError) -> RecordingError {
    match error {
        error @ RecordingError::Io(_) => error,
        error => RecordingError::format(format!("record at byte {byte}"), error.to_string()),
    }
}
