//! Encodes images as PNG files.

use nextview::sensor::{ColorImage, Depth, DepthImage};
use png::{BitDepth, ColorType, Compression, Encoder};

/// Encodes a depth image as a PNG file with 16-bit pixels in units of this many metres. Pixels without depth,
/// or with more than 65535 units, are 0.
///
/// ```
/// use glam::DVec2;
/// use nextview::sensor::{Depth, DepthImage, Intrinsics};
/// use nextview_recording::{decode_depth, encode_depth};
///
/// let camera = Intrinsics::pinhole(2, 1, DVec2::splat(3.0), DVec2::ZERO).unwrap();
/// let image = DepthImage::from_metres(2, 1, vec![0.5, f32::NAN]).unwrap();
/// let read = decode_depth(&encode_depth(&image, 0.001), None, &camera, 0.001).unwrap();
/// assert_eq!((read.get(0, 0), read.get(1, 0)), (Depth::Surface(0.5), Depth::Missing));
/// ```
pub fn encode_depth(image: &DepthImage, unit: f64) -> Vec<u8> {
    let units = |depth: Depth| match depth {
        Depth::Surface(depth) => (f64::from(depth) / unit).round(),
        Depth::Missing | Depth::Beyond => 0.0,
    };
    let units =
        image.pixels().map(units).map(|units| if units > f64::from(u16::MAX) { 0 } else { units as u16 });
    let bytes: Vec<u8> = units.flat_map(u16::to_be_bytes).collect();
    encode((image.width(), image.height()), ColorType::Grayscale, BitDepth::Sixteen, &bytes)
}

/// Encodes a colour image as a PNG file with 8 bits each of red, green and blue.
pub fn encode_color(image: &ColorImage) -> Vec<u8> {
    let bytes: Vec<u8> = image.pixels().flatten().collect();
    encode((image.width(), image.height()), ColorType::Rgb, BitDepth::Eight, &bytes)
}

/// Encodes a mask, row by row, as a PNG file with 8-bit pixels: 255 for true, 0 for false.
///
/// # Panics
/// If the mask does not have `width` times `height` pixels.
pub fn encode_mask(width: u32, height: u32, mask: &[bool]) -> Vec<u8> {
    let bytes: Vec<u8> = mask.iter().map(|is_object| if *is_object { u8::MAX } else { 0 }).collect();
    encode((width, height), ColorType::Grayscale, BitDepth::Eight, &bytes)
}

fn encode((width, height): (u32, u32), color: ColorType, bits: BitDepth, bytes: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(bits);
    encoder.set_compression(Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(bytes));
    written.expect("an image of this size, into memory");
    file
}
