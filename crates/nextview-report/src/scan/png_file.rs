use nextview::sensor::ColorImage;
use png::{BitDepth, ColorType, Compression};

/// Encodes a colour image as a PNG file.
pub fn color_png(image: &ColorImage) -> Vec<u8> {
    let samples: Vec<u8> = image.pixels().flatten().collect();
    png_file([image.width(), image.height()], &samples, None, Compression::Fast)
}

/// Encodes a PNG file with 8 bits per sample: red, green and blue of each pixel, or its palette entry.
pub fn png_file(
    [width, height]: [u32; 2],
    samples: &[u8],
    palette: Option<Vec<u8>>,
    compression: Compression,
) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(if palette.is_some() { ColorType::Indexed } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    palette.into_iter().for_each(|palette| encoder.set_palette(palette));
    encoder.set_compression(compression);
    let mut writer = encoder.write_header().expect("memory takes every byte");
    writer.write_image_data(samples).expect("as many samples as pixels");
    writer.finish().expect("memory takes every byte");
    out
}
