use super::png_file::png_file;
use nextview::sensor::ColorImage;

/// A colour image as a PNG file.
pub fn color_png(image: &ColorImage) -> Vec<u8> {
    let (width, height) = (image.width(), image.height());
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| image.get(u, v)));
    png_file([width, height], &pixels.flatten().collect::<Vec<u8>>(), None, png::Compression::Fast)
}
