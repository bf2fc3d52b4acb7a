use super::DepthImage;
use crate::Error;
use std::sync::Arc;

/// A colour image aligned pixel by pixel with a depth image of the same size, row by row from the top left.
/// Clones share the pixels.
///
/// ```
/// use nextview::sensor::ColorImage;
///
/// let image = ColorImage::new(2, 1, vec![[255, 0, 0], [0, 0, 255]]).unwrap();
/// assert_eq!(image.get(1, 0), [0, 0, 255]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColorImage {
    width: u32,
    height: u32,
    pixels: Arc<[[u8; 3]]>,
}

impl ColorImage {
    /// Returns an image from the red, green and blue of every pixel, 0 to 255. Fails unless there are `width`
    /// times `height` pixels.
    pub fn new(width: u32, height: u32, pixels: Vec<[u8; 3]>) -> Result<Self, Error> {
        if pixels.len() != width as usize * height as usize {
            let (name, value) = ("colour image", format!("{} pixels of {width} x {height}", pixels.len()));
            return Err(Error::invalid(name, value, "as many pixels as its size says"));
        }
        Ok(Self { width, height, pixels: pixels.into() })
    }

    /// Fails unless the image is as large as the depth image.
    pub fn check_fits(&self, depth: &DepthImage) -> Result<(), Error> {
        if (self.width, self.height) == (depth.width(), depth.height()) {
            return Ok(());
        }
        let value = format!("{} x {} pixels", self.width, self.height);
        Err(Error::invalid("colour image", value, "the size of the depth image"))
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns red, green and blue of the pixel in column `u` and row `v`, which must be in the image.
    pub fn get(&self, u: u32, v: u32) -> [u8; 3] {
        assert!(u < self.width && v < self.height, "pixel ({u}, {v}) lies outside the image");
        self.pixels[v as usize * self.width as usize + u as usize]
    }

    /// Returns red, green and blue of all pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = [u8; 3]> + '_ {
        self.pixels.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_another_number_of_pixels() {
        let error = ColorImage::new(2, 2, vec![[0; 3]; 3]).unwrap_err().to_string();
        assert!(error.contains("colour image is 3 pixels of 2 x 2"), "{error}");
    }
}
