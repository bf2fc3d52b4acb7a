//! Depth images as PNG files.

use crate::{RecordingError, limits};
use nextview::sensor::{DepthImage, Intrinsics};
use png::{BitDepth, ColorType, Decoder, DecodingError};
use std::io::BufReader;
use std::path::Path;

/// Reads a depth image that must be of 16 bits a pixel, without colour, and of the size that the intrinsics
/// state. The unit is in metres; 0 is a missing pixel. Where a mask of 8 bits a pixel is 0, the ray is free:
/// there is nothing of the object.
pub(crate) fn read(
    path: &Path,
    intrinsics: &Intrinsics,
    unit: f64,
    mask: Option<&Path>,
) -> Result<DepthImage, RecordingError> {
    let bytes = pixels(path, intrinsics, BitDepth::Sixteen, "depth")?;
    let mut depth: Vec<f32> = bytes
        .chunks_exact(2)
        .map(|pair| (u16::from_be_bytes([pair[0], pair[1]]) as f64 * unit) as f32)
        .collect();
    if let Some(mask) = mask {
        let mask = pixels(mask, intrinsics, BitDepth::Eight, "a mask")?;
        depth
            .iter_mut()
            .zip(mask)
            .filter(|(_, of_object)| *of_object == 0)
            .for_each(|(d, _)| *d = f32::INFINITY);
    }
    let image = DepthImage::from_metres(intrinsics.width(), intrinsics.height(), depth);
    image.map_err(|error| RecordingError::from(error).in_file(path))
}

/// The bytes of an image that must have this many bits a pixel, no colour, and the size that the intrinsics
/// state.
fn pixels(
    path: &Path,
    intrinsics: &Intrinsics,
    bits: BitDepth,
    what: &str,
) -> Result<Vec<u8>, RecordingError> {
    let decode = || {
        let mut decoder = Decoder::new(BufReader::new(limits::open(path)?));
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        let mut reader = decoder.read_info().map_err(broken)?;
        let info = reader.info();
        check_kind((info.color_type, info.bit_depth), bits, what)?;
        check_size(info.width, info.height, intrinsics)?;
        let mut bytes = vec![0; bits as usize / 8 * intrinsics.n_pixels()];
        reader.next_frame(&mut bytes).map_err(broken)?;
        Ok(bytes)
    };
    decode().map_err(|error: RecordingError| error.in_file(path))
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

/// Fails unless an image has the size that the intrinsics are for.
pub(crate) fn check_size(width: u32, height: u32, intrinsics: &Intrinsics) -> Result<(), RecordingError> {
    let expected = (intrinsics.width(), intrinsics.height());
    if (width, height) == expected {
        return Ok(());
    }
    Err(RecordingError::Content(format!(
        "the image has {width} x {height} pixels, the intrinsics are for {} x {}",
        expected.0, expected.1
    )))
}

/// The error for a file that is damaged or not a PNG.
pub(crate) fn broken(error: DecodingError) -> RecordingError {
    match error {
        DecodingError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => error.into(),
        error => RecordingError::Content(format!("is no whole PNG image: {error}")),
    }
}
