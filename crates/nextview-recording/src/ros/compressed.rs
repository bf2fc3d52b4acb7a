//! Compressed images, as sent by the plugins of `image_transport`.

use crate::{RecordingError, decode_color, decode_depth, depth_png};
use nextview::sensor::{ColorImage, DepthImage, Intrinsics};

/// A compressed image, as in `sensor_msgs/msg/CompressedImage`.
#[derive(Clone, Copy, Debug)]
pub struct CompressedImage<'a> {
    /// The format stated by the sender, such as `16UC1; compressedDepth png` or `rgb8; jpeg compressed bgr8`.
    pub format: &'a str,
    /// A JPEG or PNG file; for `compressedDepth`, preceded by twelve bytes.
    pub data: &'a [u8],
}

/// Bytes before the PNG file of `compressedDepth`: its kind, and two numbers, A and B.
const HEAD: usize = 12;

/// The kind of a `compressedDepth` with pixels A / depth + B, depth in metres.
const INVERSE_DEPTH: i32 = 0;

impl CompressedImage<'_> {
    /// Whether its pixels are depths: `compressedDepth`, or a PNG file with 16-bit pixels without colour.
    pub fn is_depth(&self) -> bool {
        self.is_compressed_depth() || depth_png::is_depth(self.data)
    }

    /// Decodes the depth. `compressedDepth` of `16UC1` and plain PNG are in millimetres; `32FC1` is quantized
    /// inverse depth, as written by the plugin `compressed_depth_image_transport`.
    ///
    /// # Errors
    /// If it is not a depth image, does not match the size in the intrinsics, is compressed in another way,
    /// or is damaged.
    pub fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError> {
        if !self.is_compressed_depth() {
            return decode_depth(self.data, None, intrinsics, 0.001);
        }
        let Some((head, file)) = self.data.split_first_chunk::<HEAD>() else {
            let n_bytes = self.data.len();
            return Err(content(format!("has {n_bytes} bytes, expected {HEAD} and a PNG file")));
        };
        if self.format.contains("rvl") {
            return Err(content(format!(
                "the format is '{}', expected compressedDepth with png",
                self.format
            )));
        }
        match self.format.split(';').next().unwrap_or_default().trim() {
            "16UC1" => decode_depth(file, None, intrinsics, 0.001),
            "32FC1" => inverse_depth(head, file, intrinsics),
            other => Err(content(format!("the encoding of the depth is '{other}', expected 16UC1 or 32FC1"))),
        }
    }

    /// Decodes a JPEG or PNG file with 8 bits each of red, green and blue.
    ///
    /// # Errors
    /// If it is damaged, or of another kind or size.
    pub fn color(&self, intrinsics: &Intrinsics) -> Result<ColorImage, RecordingError> {
        decode_color(self.data, intrinsics)
    }

    fn is_compressed_depth(&self) -> bool {
        self.format.contains("compressedDepth")
    }
}

/// Depth = A / (pixel - B), in metres; 0 is a missing pixel.
fn inverse_depth(
    head: &[u8; HEAD],
    file: &[u8],
    intrinsics: &Intrinsics,
) -> Result<DepthImage, RecordingError> {
    let word = |i: usize| [head[i], head[i + 1], head[i + 2], head[i + 3]];
    let (kind, a, b) =
        (i32::from_le_bytes(word(0)), f32::from_le_bytes(word(4)), f32::from_le_bytes(word(8)));
    if kind != INVERSE_DEPTH || !(a > 0.0 && a.is_finite() && b.is_finite()) {
        return Err(content(format!(
            "compressedDepth is of kind {kind} with A = {a} and B = {b}, expected kind 0, inverse depth, with A above 0"
        )));
    }
    let metres = |pixel: u16| match a / (pixel as f32 - b) {
        depth if pixel > 0 && depth > 0.0 && depth.is_finite() => depth,
        _ => f32::NAN,
    };
    let depth = depth_png::units(file, intrinsics)?.into_iter().map(metres).collect();
    Ok(DepthImage::from_metres(intrinsics.width(), intrinsics.height(), depth)?)
}

fn content(problem: String) -> RecordingError {
    RecordingError::Content(problem)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use nextview::sensor::Depth;
    use proptest::prelude::*;

    fn intrinsics() -> Intrinsics {
        Intrinsics::pinhole(2, 2, DVec2::ONE, DVec2::splat(0.5)).unwrap()
    }

    fn png(color: png::ColorType, depth: png::BitDepth, bytes: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 2, 2);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(bytes).unwrap();
        file
    }

    fn gray(pixels: [u16; 4]) -> Vec<u8> {
        let bytes: Vec<u8> = pixels.into_iter().flat_map(u16::to_be_bytes).collect();
        png(png::ColorType::Grayscale, png::BitDepth::Sixteen, &bytes)
    }

    fn with_head(kind: i32, a: f32, b: f32, file: &[u8]) -> Vec<u8> {
        [&kind.to_le_bytes()[..], &a.to_le_bytes(), &b.to_le_bytes(), file].concat()
    }

    #[test]
    fn millimetres_come_with_and_without_a_head() {
        let expected = DepthImage::from_units(2, 2, &[1, 0, 700, 65535], 0.001).unwrap();
        let file = gray([1, 0, 700, 65535]);
        let headed = with_head(0, 0.0, 0.0, &file);
        for (format, data) in
            [("png", &file), ("16UC1; compressedDepth", &headed), ("16UC1; compressedDepth png", &headed)]
        {
            let image = CompressedImage { format, data };
            assert!(image.is_depth());
            assert_eq!(format!("{:?}", image.depth(&intrinsics()).unwrap()), format!("{expected:?}"));
        }
    }

    #[test]
    fn inverse_depth_is_undone() {
        // As written by the plugin with its defaults: depths up to 10 m, most accurate at 100 of its units.
        let (a, max) = (100.0_f32 * 101.0, 10.0_f32);
        let b = 1.0 - a / max;
        let depths = [0.4_f32, 1.25, 9.0];
        let pixels = depths.map(|depth| (a / depth + b) as u16);
        let file = gray([pixels[0], pixels[1], pixels[2], 0]);
        let data = with_head(0, a, b, &file);
        let image = CompressedImage { format: "32FC1; compressedDepth png", data: &data };
        let found = image.depth(&intrinsics()).unwrap();
        for (i, depth) in depths.into_iter().enumerate() {
            let Depth::Surface(found) = found.get(i as u32 % 2, i as u32 / 2) else { panic!("{i}") };
            // The depth difference of one pixel value.
            assert!((found - depth).abs() <= depth * depth / a, "{found} for {depth}");
        }
        assert_eq!(found.get(1, 1), Depth::Missing);
    }

    #[test]
    fn what_is_no_depth_is_refused() {
        let file = gray([1; 4]);
        let rgb = png(png::ColorType::Rgb, png::BitDepth::Eight, &[7; 12]);
        assert!(!CompressedImage { format: "rgb8; png compressed bgr8", data: &rgb }.is_depth());
        assert!(!CompressedImage { format: "bgr8; jpeg compressed bgr8", data: &[0xff, 0xd8] }.is_depth());
        for (format, data, expected) in [
            ("16UC1; compressedDepth png", vec![0; 5], "has 5 bytes, expected 12 and a PNG file"),
            ("16UC1; compressedDepth rvl", with_head(0, 0.0, 0.0, &file), "compressedDepth rvl', expected"),
            ("mono8; compressedDepth png", with_head(0, 1.0, 0.0, &file), "'mono8', expected 16UC1 or 32FC1"),
            ("32FC1; compressedDepth png", with_head(0, 0.0, 0.0, &file), "A = 0 and B = 0, expected"),
            ("32FC1; compressedDepth png", with_head(7, 1.0, 0.0, &file), "of kind 7 with"),
            (
                "16UC1; compressedDepth png",
                with_head(0, 0.0, 0.0, &rgb),
                "8 bits with colour, expected depth",
            ),
            ("jpeg", vec![0xff, 0xd8, 0xff], "is not a complete PNG image"),
        ] {
            let error = CompressedImage { format, data: &data }.depth(&intrinsics()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    proptest! {
        #[test]
        fn never_panics(format in 0..5_usize, at in 0..90_usize, byte: u8, cut in 0..90_usize) {
            let formats = ["png", "16UC1; compressedDepth png", "32FC1; compressedDepth png", "", "jpeg"];
            let mut data = with_head(0, 100.0, -1.0, &gray([1, 2, 3, 4]));
            let length = data.len();
            data[at % length] = byte;
            data.truncate(length.saturating_sub(cut).max(1));
            let image = CompressedImage { format: formats[format], data: &data };
            let _ = (image.is_depth(), image.depth(&intrinsics()).is_ok(), image.color(&intrinsics()).is_ok());
        }
    }
}
