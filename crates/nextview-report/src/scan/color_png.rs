use nextview::sensor::ColorImage;

/// A colour image as a PNG file.
pub fn color_png(image: &ColorImage) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
    let mut writer = encoder.write_header().expect("memory takes every byte");
    writer.write_image_data(&pixels.flatten().collect::<Vec<u8>>()).expect("three bytes per pixel");
    writer.finish().expect("memory takes every byte");
    out
}
