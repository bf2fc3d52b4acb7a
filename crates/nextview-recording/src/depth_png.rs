//! Depth images as PNG files.

use crate::RecordingError;
use nextview::sensor::{DepthImage, Intrinsics};
use png::{BitDepth, ColorType, Decoder, DecodingError};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads a depth image that must be of 16 bits a pixel, without colour, and of the size that the intrinsics state. The unit is
/// in metres; 0 is a missing pixel.
pub(crate) fn read(path: &Path, intrinsics: &Intrinsics, unit: f64) -> Result<DepthImage, RecordingError> {
    decode(path, intrinsics, unit).map_err(|error| error.in_file(path))
}

fn decode(path: &Path, intrinsics: &Intrinsics, unit: f64) -> Result<DepthImage, RecordingError> {
    let mut reader = Decoder::new(BufReader::new(File::open(path)?)).read_info().map_err(broken)?;
    let info = reader.info();
    check_kind(info.color_type, info.bit_depth)?;
    check_size(info.width, info.height, intrinsics)?;
    let mut bytes = vec![0; 2 * intrinsics.n_pixels()];
    reader.next_frame(&mut bytes).map_err(broken)?;
    let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
    Ok(DepthImage::from_units(intrinsics.width(), intrinsics.height(), &units, unit)?)
}

fn check_kind(color: ColorType, depth: BitDepth) -> Result<(), RecordingError> {
    if (color, depth) == (ColorType::Grayscale, BitDepth::Sixteen) {
        return Ok(());
    }
    let kind = match color {
        ColorType::Grayscale => "without colour",
        _ => "with colour",
    };
    Err(RecordingError::Content(format!(
        "is a PNG image of {} bits {kind}, expected depth: 16 bits a pixel without colour",
        depth as u8
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

/// What a decoder says of a file that is damaged or no PNG.
pub(crate) fn broken(error: DecodingError) -> RecordingError {
    match error {
        DecodingError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => error.into(),
        error => RecordingError::Content(format!("is no whole PNG image: {error}")),
    }
}
