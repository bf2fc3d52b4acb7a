//! The images on a mesh: PNG or JPEG files.

use crate::SimError;
use jpeg_decoder::PixelFormat;
use nextview::sensor::ColorImage;
use png::{ColorType, Transformations};
use std::io::Cursor;

/// Maximum number of pixels of all images of a mesh: 200 MB. Sizes are checked before pixels are decoded.
const MAX_PIXELS: u64 = 1 << 26;

/// Loads the file behind a relative name in a mesh file.
pub(super) type Resolve<'a> = dyn Fn(&str) -> Result<Vec<u8>, SimError> + 'a;

/// The images of one mesh, each decoded once.
#[derive(Default)]
pub(super) struct Images {
    /// By name.
    decoded: Vec<(String, ColorImage)>,
    n_pixels: u64,
}

impl Images {
    /// Returns the image with this name, loading its bytes on first use; errors name it.
    pub fn get(
        &mut self,
        name: &str,
        bytes: impl FnOnce() -> Result<Vec<u8>, SimError>,
    ) -> Result<ColorImage, SimError> {
        if let Some((_, image)) = self.decoded.iter().find(|(other, _)| other == name) {
            return Ok(image.clone());
        }
        let left = MAX_PIXELS - self.n_pixels;
        let image = bytes()
            .and_then(|bytes| decode(&bytes, left).map_err(|problem| SimError::format("image", problem)));
        let image =
            image.map_err(|error| SimError::format(format!("texture {name:?}"), error.to_string()))?;
        self.n_pixels += u64::from(image.width()) * u64::from(image.height());
        self.decoded.push((name.to_owned(), image.clone()));
        Ok(image)
    }
}

fn decode(bytes: &[u8], max_pixels: u64) -> Result<ColorImage, String> {
    let (size, channels, values) = match bytes.starts_with(&[0xff, 0xd8]) {
        true => decode_jpeg(bytes, max_pixels)?,
        false => decode_png(bytes, max_pixels)?,
    };
    let pixels = values.chunks_exact(channels).map(|pixel| match *pixel {
        [red, green, blue, ..] => [red, green, blue],
        _ => [pixel[0]; 3],
    });
    ColorImage::new(size[0], size[1], pixels.collect()).map_err(|error| error.to_string())
}

/// Width and height, values per pixel, and the values.
type Decoded = ([u32; 2], usize, Vec<u8>);

fn decode_png(bytes: &[u8], max_pixels: u64) -> Result<Decoded, String> {
    let broken = |error: png::DecodingError| format!("is not a complete PNG or JPEG image: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let size = [reader.info().width, reader.info().height];
    check_size(size, max_pixels)?;
    let channels = match reader.output_color_type().0 {
        ColorType::Grayscale | ColorType::Indexed => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
    };
    let mut values = vec![0; size[0] as usize * size[1] as usize * channels];
    reader.next_frame(&mut values).map_err(broken)?;
    // A file that ends here was truncated.
    reader.finish().map_err(broken)?;
    Ok((size, channels, values))
}

fn decode_jpeg(bytes: &[u8], max_pixels: u64) -> Result<Decoded, String> {
    let broken = |error: jpeg_decoder::Error| format!("is not a complete JPEG image: {error}");
    let mut decoder = jpeg_decoder::Decoder::new(bytes);
    decoder.read_info().map_err(broken)?;
    let info = decoder.info().ok_or("is a JPEG image without a header")?;
    let size = [info.width.into(), info.height.into()];
    check_size(size, max_pixels)?;
    let channels = match info.pixel_format {
        PixelFormat::L8 => 1,
        PixelFormat::RGB24 => 3,
        other => return Err(format!("is a JPEG image, {other:?}, expected grey or RGB of 8 bits each")),
    };
    Ok((size, channels, decoder.decode().map_err(broken)?))
}

fn check_size([width, height]: [u32; 2], max_pixels: u64) -> Result<(), String> {
    if width > 0 && height > 0 && u64::from(width) * u64::from(height) <= max_pixels {
        return Ok(());
    }
    Err(format!(
        "has {width} x {height} pixels, expected at least one, and at most {MAX_PIXELS} in all images of the mesh"
    ))
}

/// A small PNG file.
#[cfg(test)]
pub(super) fn png_bytes(width: u32, height: u32, kind: ColorType, values: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(kind);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(values).unwrap();
    writer.finish().unwrap();
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_grey_and_colour_with_and_without_alpha() {
        let get = |kind, values: &[u8]| {
            let bytes = png_bytes(1, 2, kind, values);
            let image = Images::default().get("a.png", || Ok(bytes)).unwrap();
            [image.get(0, 0), image.get(0, 1)]
        };
        assert_eq!(get(ColorType::Grayscale, &[7, 9]), [[7; 3], [9; 3]]);
        assert_eq!(get(ColorType::GrayscaleAlpha, &[7, 1, 9, 1]), [[7; 3], [9; 3]]);
        assert_eq!(get(ColorType::Rgb, &[1, 2, 3, 4, 5, 6]), [[1, 2, 3], [4, 5, 6]]);
        assert_eq!(get(ColorType::Rgba, &[1, 2, 3, 0, 4, 5, 6, 0]), [[1, 2, 3], [4, 5, 6]]);
    }

    #[test]
    fn faults_name_the_image() {
        let whole = png_bytes(2, 2, ColorType::Rgb, &[9; 12]);
        for bytes in [&whole[..whole.len() - 9], &[], b"\xff\xd8\xff", b"GIF89a"] {
            let error = Images::default().get("a.png", || Ok(bytes.to_vec())).unwrap_err().to_string();
            assert!(error.starts_with("texture \"a.png\": image: is "), "{error}");
        }
        let huge = png_bytes(1, 1, ColorType::Rgb, &[1, 2, 3]);
        let error = decode(&huge, 0).unwrap_err();
        assert!(error.starts_with("has 1 x 1 pixels"), "{error}");
    }

    #[test]
    fn an_image_is_loaded_once() {
        let mut images = Images::default();
        let bytes = png_bytes(1, 1, ColorType::Rgb, &[1, 2, 3]);
        let first = images.get("a", || Ok(bytes)).unwrap();
        assert_eq!(images.get("a", || unreachable!()).unwrap(), first);
    }
}
