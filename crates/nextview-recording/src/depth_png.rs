//! Depth images as PNG files.

use crate::{RecordingError, limits};
use nextview::sensor::{DepthImage, Intrinsics};
use png::{BitDepth, ColorType, Decoder, DecodingError};
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

/// Decodes the bytes of a PNG file with 16-bit pixels, without colour, of the size in the intrinsics. `unit`
/// is the length of a depth unit in metres, positive; 0 is a missing pixel. `mask` is a PNG file with 8-bit
/// pixels. Where it is 0, the ray is free and misses the object.
///
/// The size is checked before pixels are decoded, which limits memory to the stated size.
///
/// # Errors
/// If an image is damaged, or of another kind or size.
pub fn decode_depth(
    png: &[u8],
    mask: Option<&[u8]>,
    intrinsics: &Intrinsics,
    unit: f64,
) -> Result<DepthImage, RecordingError> {
    let depth = pixels(Cursor::new(png), intrinsics, BitDepth::Sixteen, "depth")?;
    let mask = mask.map(|mask| {
        pixels(Cursor::new(mask), intrinsics, BitDepth::Eight, "a mask").map_err(|error| match error {
            RecordingError::Content(problem) => RecordingError::Content(format!("the mask {problem}")),
            error => error,
        })
    });
    image(&depth, mask.transpose()?, intrinsics, unit)
}

/// Decodes depth and mask files.
pub(crate) fn read(
    path: &Path,
    intrinsics: &Intrinsics,
    unit: f64,
    mask: Option<&Path>,
) -> Result<DepthImage, RecordingError> {
    let file = |path: &Path, bits, what| {
        let open = || pixels(BufReader::new(limits::open(path)?), intrinsics, bits, what);
        open().map_err(|error| error.in_file(path))
    };
    let depth = file(path, BitDepth::Sixteen, "depth")?;
    let mask = mask.map(|mask| file(mask, BitDepth::Eight, "a mask")).transpose()?;
    image(&depth, mask, intrinsics, unit).map_err(|error| error.in_file(path))
}

/// Whether these are the bytes of a PNG file with 16-bit pixels without colour, as stated in its head.
pub(crate) fn is_depth(bytes: &[u8]) -> bool {
    let info = Decoder::new(Cursor::new(bytes)).read_info();
    info.is_ok_and(|reader| {
        let info = reader.info();
        (info.color_type, info.bit_depth) == (ColorType::Grayscale, BitDepth::Sixteen)
    })
}

/// The pixels of a PNG file with 16-bit pixels, without colour, of the size in the intrinsics.
pub(crate) fn units(png: &[u8], intrinsics: &Intrinsics) -> Result<Vec<u16>, RecordingError> {
    let bytes = pixels(Cursor::new(png), intrinsics, BitDepth::Sixteen, "depth")?;
    Ok(bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect())
}

fn image(
    depth: &[u8],
    mask: Option<Vec<u8>>,
    intrinsics: &Intrinsics,
    unit: f64,
) -> Result<DepthImage, RecordingError> {
    let metres = |pair: &[u8]| (u16::from_be_bytes([pair[0], pair[1]]) as f64 * unit) as f32;
    let mut depth: Vec<f32> = depth.chunks_exact(2).map(metres).collect();
    let beyond = depth.iter_mut().zip(mask.iter().flatten()).filter(|(_, of_object)| **of_object == 0);
    beyond.for_each(|(depth, _)| *depth = f32::INFINITY);
    Ok(DepthImage::from_metres(intrinsics.width(), intrinsics.height(), depth)?)
}

/// The bytes of an image that must have this number of bits per pixel, no colour, and the size in the
/// intrinsics.
fn pixels(
    file: impl BufRead + Seek,
    intrinsics: &Intrinsics,
    bits: BitDepth,
    what: &str,
) -> Result<Vec<u8>, RecordingError> {
    let mut decoder = Decoder::new(file);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    check_kind((info.color_type, info.bit_depth), bits, what)?;
    check_size(info.width, info.height, intrinsics)?;
    let mut bytes = vec![0; bits as usize / 8 * intrinsics.n_pixels()];
    reader.next_frame(&mut bytes).map_err(broken)?;
    // A file that ends here is truncated.
    reader.finish().map_err(broken)?;
    Ok(bytes)
}

fn check_kind(kind: (ColorType, BitDepth), bits: BitDepth, what: &str) -> Result<(), RecordingError> {
    if kind == (ColorType::Grayscale, bits) {
        return Ok(());
    }
    let (color, depth) = kind;
    let color = match color {
        ColorType::Grayscale => "without colour",
        _ => "with colour",
    };
    Err(RecordingError::Content(format!(
        "is a PNG image of {} bits {color}, expected {what}: {} bits a pixel without colour",
        depth as u8, bits as u8
    )))
}

/// Fails unless an image has the size in the intrinsics.
pub(crate) fn check_size(width: u32, height: u32, intrinsics: &Intrinsics) -> Result<(), RecordingError> {
    let expected = (intrinsics.width(), intrinsics.height());
    if (width, height) == expected {
        return Ok(());
    }
    Err(RecordingError::Content(format!(
        "the image has {width} x {height} pixels, but the intrinsics are for {} x {}",
        expected.0, expected.1
    )))
}

/// The error for a damaged file or one that is not a PNG.
pub(crate) fn broken(error: DecodingError) -> RecordingError {
    match error {
        DecodingError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => error.into(),
        error => RecordingError::Content(format!("is not a complete PNG image: {error}")),
    }
}
