use crate::Fault;
use nextview::text;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Opens a regular file for reading. Devices and pipes may never end.
pub fn open(path: &Path) -> Result<BufReader<File>, Fault> {
    let open = || {
        let kind = path.metadata()?;
        match () {
            _ if kind.is_dir() => Err(Fault::data("it is a folder, expected a file")),
            _ if !kind.is_file() => Err(Fault::data("it is a device, a pipe or a socket, expected a file")),
            _ => Ok(BufReader::new(File::open(path)?)),
        }
    };
    open().map_err(|fault| unreadable(path, &fault))
}

/// Reads a regular file of at most this many bytes.
pub fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    let read = open(path)?.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| unreadable(path, &error.into()))?;
    if bytes.len() as u64 > max_bytes {
        let size = path.metadata().map_or(bytes.len() as u64, |of| of.len());
        let problem = format!("it has {size} bytes, expected at most {max_bytes}");
        return Err(unreadable(path, &Fault::data(problem)));
    }
    Ok(bytes)
}

/// Reads a text without its byte order mark; a lone carriage return becomes a line feed.
pub fn read_text(path: &Path, max_bytes: u64) -> Result<String, Fault> {
    text::utf8(read(path, max_bytes)?).map_err(|error| unreadable(path, &error.into()))
}

fn unreadable(path: &Path, fault: &Fault) -> Fault {
    Fault::data(format!("cannot be read: {}", fault.message)).in_file(path)
}
