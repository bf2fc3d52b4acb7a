//! Limits on a recording's content in proportion to its size: small files must not fill the memory.
//!
//! Memory stays below 20 times the size of the files plus 200 MB. Sizes stated in a file are checked against
//! this before memory is reserved.

use crate::RecordingError;
use nextview::sensor::Intrinsics;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Maximum size of a text file in bytes.
pub(crate) const MAX_TEXT: u64 = 1 << 26;

/// Maximum length of a line of a text file in bytes.
const MAX_LINE: usize = 1 << 16;

/// Number of list entries, such as images or poses, allowed in a file of any size; an entry takes up to 300
/// bytes.
const FREE_ENTRIES: u64 = 200_000;

/// Memory for images allowed for files of any size, in bytes: enough for 1280 x 720 pixels.
const FREE_MEMORY: u64 = 175_000_000;

/// Memory of a scan per pixel of the current image and of each held one, in bytes, rounded up from scans of
/// images of two million pixels.
const BYTES_PER_PIXEL: u64 = 120;
const BYTES_PER_HELD_PIXEL: u64 = 6;

/// Number of images held by a scan, unless more views are requested.
const HELD: usize = 10;

/// Maximum size of an MCAP chunk at any compression ratio, in bytes. Recorders write chunks of a megabyte.
const FREE_CHUNK: u64 = 1 << 25;

/// Total size of an MCAP file's chunks allowed at any compression ratio, in bytes: read within seconds.
const FREE_CHUNKS: u64 = 1 << 30;

/// Opens a regular file: devices and pipes may never end.
pub(crate) fn open(path: &Path) -> Result<File, RecordingError> {
    if !path.metadata()?.is_file() {
        return Err(RecordingError::Content("is not a regular file".into()));
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

/// Fails on a line that is too long for a list or a table.
pub(crate) fn check_lines(text: &str) -> Result<(), RecordingError> {
    match text.lines().position(|line| line.len() > MAX_LINE) {
        Some(i) => {
            let problem = format!("is longer than {MAX_LINE} bytes");
            Err(RecordingError::format(format!("line {}", i + 1), problem))
        }
        None => Ok(()),
    }
}

/// Fails if the number of entries is implausible for a file of this size.
pub(crate) fn check_entries(n_entries: usize, n_bytes: u64) -> Result<(), RecordingError> {
    let max = FREE_ENTRIES.saturating_add(n_bytes / 32);
    if n_entries as u64 <= max {
        return Ok(());
    }
    let problem = format!("holds {n_entries} entries in {n_bytes} bytes, expected at most {max}");
    Err(RecordingError::Content(problem))
}

/// Fails if images have more pixels than plausible for the total size of these files.
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
        "the images have {} x {} = {n_pixels} pixels, expected at most {max} in {n_images} images of \
         {n_bytes} bytes in total",
        intrinsics.width(),
        intrinsics.height()
    )))
}

/// Fails if the stated size of a chunk is implausible.
pub(crate) fn check_chunk(plain: u64, packed: u64) -> Result<(), RecordingError> {
    let max = FREE_CHUNK.saturating_add(packed.saturating_mul(8));
    if plain <= max {
        return Ok(());
    }
    Err(RecordingError::Content(format!(
        "a chunk states {plain} bytes for {packed} compressed ones, expected at most {max}"
    )))
}

/// Fails if this total size of chunks is implausible for a file of this size.
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
