use super::png_file::png_file;
use nextview::sensor::ColorImage;

/// Encodes a colour image as a PNG file.
pub fn color_png(image: &ColorImage) -> Vec<u8> {
    let samples: Vec<u8> = image.pixels().flatten().collect();
    png_file([image.width(), image.height()], &samples, None, png::Compression::Fast)
}
