//! Colour images as PNG or JPEG files.

use crate::depth_png::broken;
use crate::{RecordingError, limits};
use jpeg_decoder::{Error as JpegError, PixelFormat};
use nextview::sensor::{ColorImage, Intrinsics};
use png::{BitDepth, ColorType, Transformations};
use std::io::Cursor;
use std::path::Path;

/// The first bytes of a JPEG file.
const JPEG: [u8; 2] = [0xff, 0xd8];

/// Decodes the bytes of a PNG or JPEG file, which must have 8 bits each of red, green and blue, and the size
/// in the intrinsics of the depth. The size is checked before pixels are decoded.
///
/// # Errors
/// If the image is damaged, or of another kind or size.
pub fn decode_color(bytes: &[u8], intrinsics: &Intrinsics) -> Result<ColorImage, RecordingError> {
    let pixels = match bytes.starts_with(&JPEG) {
        true => decode_jpeg(bytes, intrinsics)?,
        false => decode_png(bytes, intrinsics)?,
    };
    let pixels = pixels.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
    Ok(ColorImage::new(intrinsics.width(), intrinsics.height(), pixels)?)
}

/// Decodes a colour image file.
pub(crate) fn read(path: &Path, intrinsics: &Intrinsics) -> Result<ColorImage, RecordingError> {
    // A few times the pixels; other content, such as a preview, is smaller.
    let bytes = limits::read(path, (1 << 20) + 12 * intrinsics.n_pixels() as u64);
    let image = bytes.and_then(|bytes| decode_color(&bytes, intrinsics));
    image.map_err(|error| error.in_file(path))
}

fn decode_png(bytes: &[u8], intrinsics: &Intrinsics) -> Result<Vec<u8>, RecordingError> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    check_kind((info.color_type, info.bit_depth) == (ColorType::Rgb, BitDepth::Eight), || {
        format!("a PNG image of {} bits, {:?}", info.bit_depth as u8, info.color_type)
    })?;
    check_size((info.width, info.height), intrinsics)?;
    let mut pixels = vec![0; 3 * intrinsics.n_pixels()];
    reader.next_frame(&mut pixels).map_err(broken)?;
    // A file that ends here is truncated.
    reader.finish().map_err(broken)?;
    Ok(pixels)
}

fn decode_jpeg(bytes: &[u8], intrinsics: &Intrinsics) -> Result<Vec<u8>, RecordingError> {
    let broken = |error: JpegError| RecordingError::Content(format!("is not a complete JPEG image: {error}"));
    let mut decoder = jpeg_decoder::Decoder::new(bytes);
    decoder.read_info().map_err(broken)?;
    let info =
        decoder.info().ok_or_else(|| RecordingError::Content("is a JPEG image without a header".into()))?;
    check_kind(info.pixel_format == PixelFormat::RGB24, || format!("a JPEG image, {:?}", info.pixel_format))?;
    check_size((info.width.into(), info.height.into()), intrinsics)?;
    decoder.decode().map_err(broken)
}

fn check_kind(is_right: bool, kind: impl Fn() -> String) -> Result<(), RecordingError> {
    let problem = || format!("is {}, expected colour: 8 bits of red, green and blue each", kind());
    if is_right { Ok(()) } else { Err(RecordingError::Content(problem())) }
}

pub(crate) fn check_size(size: (u32, u32), intrinsics: &Intrinsics) -> Result<(), RecordingError> {
    let expected = (intrinsics.width(), intrinsics.height());
    if size == expected {
        return Ok(());
    }
    Err(RecordingError::Content(format!(
        "the colour image has {} x {} pixels, expected the size of the depth image, {} x {}; leave out \
         colour images that are not aligned with the depth images pixel by pixel",
        size.0, size.1, expected.0, expected.1
    )))
}
