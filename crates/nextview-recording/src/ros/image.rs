use crate::RecordingError;
use crate::color_file::check_size as check_color_size;
use crate::depth_png::check_size;
use nextview::sensor::{ColorImage, DepthImage, Intrinsics};

/// An uncompressed image, as in `sensor_msgs/msg/Image`.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The format of a pixel; see [`is_depth`](Self::is_depth).
    pub encoding: &'a str,
    /// Whether the highest byte of a pixel comes first.
    pub is_big_endian: bool,
    /// Bytes from one row to the next.
    pub step: u32,
    /// Consecutive rows.
    pub data: &'a [u8],
}

impl Image<'_> {
    /// Whether its pixels are depths (REP 118): `16UC1`, millimetres, or `32FC1`, metres.
    pub fn is_depth(&self) -> bool {
        matches!(self.encoding, "16UC1" | "32FC1")
    }

    /// Decodes the depth. Infinite depths in metres count as missing: they only say that the surface is
    /// beyond a range that is not known.
    ///
    /// # Errors
    /// If it is not a depth image, does not match the size in the intrinsics, or is shorter than stated.
    pub fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError> {
        check_size(self.width, self.height, intrinsics)?;
        match self.encoding {
            "16UC1" => {
                let units: Vec<u16> = self.pixels()?.map(u16::from_le_bytes).collect();
                Ok(DepthImage::from_units(self.width, self.height, &units, 0.001)?)
            }
            "32FC1" => {
                let metres = self.pixels()?.map(f32::from_le_bytes);
                let metres = metres.map(|depth| if depth.is_finite() { depth } else { f32::NAN });
                Ok(DepthImage::from_metres(self.width, self.height, metres.collect())?)
            }
            other => Err(of_encoding(other, "depth: 16UC1 (millimetres) or 32FC1 (metres)")),
        }
    }

    /// Decodes the colours of `rgb8` or `bgr8`.
    ///
    /// # Errors
    /// If it has another encoding, does not match the size in the intrinsics, or is shorter than stated.
    pub fn color(&self, intrinsics: &Intrinsics) -> Result<ColorImage, RecordingError> {
        check_color_size((self.width, self.height), intrinsics)?;
        let rgb: fn([u8; 3]) -> [u8; 3] = match self.encoding {
            "rgb8" => |rgb| rgb,
            "bgr8" => |[b, g, r]| [r, g, b],
            other => return Err(of_encoding(other, "colour: rgb8 or bgr8")),
        };
        let pixels = self.rows()?.map(rgb).collect();
        Ok(ColorImage::new(self.width, self.height, pixels)?)
    }

    /// The bytes of the pixels, lowest byte first.
    fn pixels<const N: usize>(&self) -> Result<impl Iterator<Item = [u8; N]>, RecordingError> {
        let is_big_endian = self.is_big_endian;
        Ok(self.rows()?.map(move |mut pixel| {
            if is_big_endian {
                pixel.reverse();
            }
            pixel
        }))
    }

    /// The bytes of the pixels, unchanged.
    fn rows<const N: usize>(&self) -> Result<impl Iterator<Item = [u8; N]>, RecordingError> {
        let (row, step) = (N * self.width as usize, self.step as usize);
        let needed = step * (self.height as usize - 1) + row;
        if step < row || self.data.len() < needed {
            return Err(RecordingError::Content(format!(
                "the image has {} bytes in rows of {step}, expected {} rows of at least {row} bytes",
                self.data.len(),
                self.height
            )));
        }
        let rows = self.data.chunks(step).take(self.height as usize);
        Ok(rows.flat_map(move |bytes| bytes[..row].as_chunks::<N>().0).copied())
    }
}

fn of_encoding(encoding: &str, expected: &str) -> RecordingError {
    RecordingError::Content(format!("the encoding is '{encoding}', expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn image<'a>(encoding: &'a str, is_big_endian: bool, step: u32, data: &'a [u8]) -> Image<'a> {
        Image { width: 2, height: 2, encoding, is_big_endian, step, data }
    }

    fn intrinsics() -> Intrinsics {
        Intrinsics::pinhole(2, 2, DVec2::ONE, DVec2::splat(0.5)).unwrap()
    }

    #[test]
    fn rows_may_be_padded_and_bytes_in_either_order() {
        let expected = DepthImage::from_units(2, 2, &[1, 2, 256, 0], 0.001).unwrap();
        let same = |image: Image<'_>| {
            format!("{:?}", image.depth(&intrinsics()).unwrap()) == format!("{expected:?}")
        };
        assert!(same(image("16UC1", false, 4, &[1, 0, 2, 0, 0, 1, 0, 0])));
        assert!(same(image("16UC1", true, 5, &[0, 1, 0, 2, 9, 1, 0, 0, 0])));
        let metres = [0.001_f32, 0.002, 0.256, f32::INFINITY];
        let little: Vec<u8> = metres.iter().flat_map(|m| m.to_le_bytes()).collect();
        let big: Vec<u8> = metres.iter().flat_map(|m| m.to_be_bytes()).collect();
        assert!(same(image("32FC1", false, 8, &little)) && same(image("32FC1", true, 8, &big)));
    }

    #[test]
    fn images_that_are_too_short_are_refused() {
        for (step, n) in [(3, 8), (4, 7), (5, 8), (u32::MAX, 8)] {
            let error =
                image("16UC1", false, step, &vec![0; n]).depth(&intrinsics()).unwrap_err().to_string();
            assert!(error.contains("expected 2 rows of at least 4 bytes"), "{error}");
        }
    }

    #[test]
    fn colours_come_in_either_order_and_other_encodings_are_named() {
        let bytes = [1, 2, 3, 4, 5, 6, 9, 7, 8, 9, 10, 11, 12];
        let rgb = image("rgb8", true, 7, &bytes).color(&intrinsics()).unwrap();
        let bgr = image("bgr8", false, 7, &bytes).color(&intrinsics()).unwrap();
        assert_eq!((rgb.get(1, 0), bgr.get(1, 0), rgb.get(1, 1)), ([4, 5, 6], [6, 5, 4], [10, 11, 12]));
        let error = image("mono8", false, 2, &[0; 4]).depth(&intrinsics()).unwrap_err().to_string();
        assert!(error.contains("'mono8', expected depth: 16UC1 (millimetres) or 32FC1 (metres)"), "{error}");
        assert!(image("mono8", false, 2, &[0; 4]).color(&intrinsics()).is_err());
    }
}
