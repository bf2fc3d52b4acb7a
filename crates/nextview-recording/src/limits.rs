//! Limits of a recording's content in proportion to its size: small files must not fill the memory.
//!
//! Everything that is read stays below 20 times the size of its files plus 200 MB. What a file states of its
//! own content is checked against that before memory is reserved.

use crate::RecordingError;
use nextview::sensor::Intrinsics;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest text file, bytes.
pub(crate) const MAX_TEXT: u64 = 1 << 26;

/// Longest line of a text file, bytes.
const MAX_LINE: usize = 1 << 16;

/// Entries of a list, such as images or poses, that a file of any size may hold; an entry takes up to 300
/// bytes.
const FREE_ENTRIES: u64 = 200_000;

/// Memory that images may take however small their files are, bytes: 1280 x 720 pixels are within it.
const FREE_MEMORY: u64 = 175_000_000;

/// Memory that a scan takes for a pixel of the image that it works on, and of each one that it holds, bytes,
/// rounded up from scans of images of two million pixels.
const BYTES_PER_PIXEL: u64 = 120;
const BYTES_PER_HELD_PIXEL: u64 = 6;

/// Images that a scan holds, unless more views are asked for.
const HELD: usize = 10;

/// Bytes that a chunk of an MCAP file may have however well it is compressed. Recorders make chunks of a
/// megabyte.
const FREE_CHUNK: u64 = 1 << 25;

/// Bytes that all chunks of an MCAP file may have however well they are compressed: what is read in seconds.
const FREE_CHUNKS: u64 = 1 << 30;

/// Opens a regular file: devices and pipes may never end.
pub(crate) fn open(path: &Path) -> Result<File, RecordingError> {
    if !path.metadata()?.is_file() {
        return Err(RecordingError::Content("is not a regular file, expected a file".into()));
    }
    Ok(File::open(path)?)
}

/// Reads a regular file of at most this many bytes.
pub(crate) fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, RecordingError> {
    let mut bytes = Vec::new();
    open(path)?.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 <= max_bytes {
        return Ok(bytes);
    }
    let size = path.metadata().map_or(bytes.len() as u64, |of| of.len());
    Err(RecordingError::Content(format!("has {size} bytes, expected at most {max_bytes}")))
}

/// Fails on a line that is too long to be one of a list or a table.
pub(crate) fn check_lines(text: &str) -> Result<(), RecordingError> {
    match text.lines().position(|line| line.len() > MAX_LINE) {
        Some(i) => {
            let problem = format!("is longer than {MAX_LINE} bytes");
            Err(RecordingError::format(format!("line {}", i + 1), problem))
        }
        None => Ok(()),
    }
}

/// Fails if a file of this size holds more entries than files of its kind do.
pub(crate) fn check_entries(n_entries: usize, n_bytes: u64) -> Result<(), RecordingError> {
    let max = FREE_ENTRIES.saturating_add(n_bytes / 32);
    if n_entries as u64 <= max {
        return Ok(());
    }
    let problem = format!("holds {n_entries} entries in {n_bytes} bytes, expected at most {max}");
    Err(RecordingError::Content(problem))
}

/// Fails if images have more pixels than files of this size in all can stand for.
pub(crate) fn check_pixels(
    intrinsics: &Intrinsics,
    n_images: usize,
    n_bytes: u64,
) -> Result<(), RecordingError> {
    let n_held = n_images.min(HELD) as u64;
    let memory = FREE_MEMORY.saturating_add(n_bytes.saturating_mul(20));
    let max = memory / (BYTES_PER_PIXEL + n_held * BYTES_PER_HELD_PIXEL);
    let n_pixels = intrinsics.n_pixels() as u64;
    if n_pixels <= max {
        return Ok(());
    }
    Err(RecordingError::Content(format!(
        "the images have {} x {} = {n_pixels} pixels, expected at most {max} in {n_images} images of {n_bytes} bytes \
         together",
        intrinsics.width(),
        intrinsics.height()
    )))
}

/// Fails if a chunk states more bytes than it can stand for.
pub(crate) fn check_chunk(plain: u64, packed: u64) -> Result<(), RecordingError> {
    let max = FREE_CHUNK.saturating_add(packed.saturating_mul(8));
    if plain <= max {
        return Ok(());
    }
    Err(RecordingError::Content(format!(
        "a chunk states {plain} bytes for {packed} compressed ones, expected at most {max}"
    )))
}

/// Fails if so many bytes are more than the chunks of a file of this size can stand for.
pub(crate) fn check_chunks(plain: u64, n_bytes: u64) -> Result<(), RecordingError> {
    let max = FREE_CHUNKS.saturating_add(n_bytes.saturating_mul(64));
    if plain <= max {
        return Ok(());
    }
    let problem = format!("its chunks have {plain} bytes so far, expected at most {max} in {n_bytes} bytes");
    Err(RecordingError::Content(problem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn what_cameras_record_is_within_the_limits() {
        let camera = |width, height| {
            Intrinsics::pinhole(width, height, DVec2::splat(500.0), DVec2::splat(10.0)).unwrap()
        };
        check_pixels(&camera(1280, 720), 36, 100_000).unwrap();
        check_pixels(&camera(1944, 1200), 20, 20 * 700_000).unwrap();
        check_pixels(&camera(4096, 3000), 20, 20 * 10_000_000).unwrap();
        let error = check_pixels(&camera(32768, 32768), 1, 2_000_000).unwrap_err().to_string();
        let parts = ["= 1073741824 pixels, expected at most 1706349", " in 1 images of 2000000 bytes"];
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        check_chunk(30_000_000, 1000).unwrap();
        let error = check_chunk(10_000_000_000, 197_000).unwrap_err().to_string();
        assert!(
            error.contains("10000000000 bytes for 197000 compressed ones, expected at most 35130432"),
            "{error}"
        );
        check_entries(200_000, 0).unwrap();
        assert!(check_entries(300_000, 1_000_000).unwrap_err().to_string().contains("at most 231250"));
        assert_eq!(
            check_lines(&format!("a\n{}\n", "b".repeat(65_537))).unwrap_err().to_string(),
            "line 2: is longer than 65536 bytes"
        );
    }
}
