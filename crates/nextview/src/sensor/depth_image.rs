use crate::Error;
use std::sync::Arc;

/// The reading of one pixel of a depth image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// No measurement.
    Missing,
    /// No return: the ray is free up to the camera's range.
    Beyond,
    /// A surface at this depth along the camera's z axis, metres, positive and finite.
    Surface(f32),
}

impl Depth {
    /// Returns the number for [`DepthImage::from_metres`]: metres, NaN without measurement, infinite without
    /// return.
    pub fn metres(self) -> f32 {
        match self {
            Self::Missing => f32::NAN,
            Self::Beyond => f32::INFINITY,
            Self::Surface(depth) => depth,
        }
    }
}

/// A depth image, row by row from the top left, in metres along the camera's z axis. Clones share the pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthImage {
    width: u32,
    height: u32,
    /// Positive and finite: a surface. NaN: missing. Infinite: no return.
    depth: Arc<[f32]>,
}

impl DepthImage {
    /// Returns an image from depths in metres. Zero, negative numbers and NaN are missing pixels; positive
    /// infinity is a pixel without return.
    pub fn from_metres(width: u32, height: u32, mut depth: Vec<f32>) -> Result<Self, Error> {
        if depth.len() != width as usize * height as usize {
            return Err(Error::ImageSize { actual: depth.len(), width, height });
        }
        for d in &mut depth {
            if *d <= 0.0 {
                *d = f32::NAN;
            }
        }
        Ok(Self { width, height, depth: depth.into() })
    }

    /// Returns an image from raw units, as in depth cameras and 16-bit PNG files; `scale` is the size of a
    /// unit in metres (0.001 for millimetres) and must be positive. Zero is a missing pixel.
    pub fn from_units(width: u32, height: u32, units: &[u16], scale: f64) -> Result<Self, Error> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::invalid("depth scale", scale, "a positive number of metres per unit"));
        }
        Self::from_metres(width, height, units.iter().map(|&d| (d as f64 * scale) as f32).collect())
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the pixel in column `u` and row `v`, which must be in the image.
    pub fn get(&self, u: u32, v: u32) -> Depth {
        assert!(u < self.width && v < self.height, "pixel ({u}, {v}) lies outside the image");
        reading(self.depth[v as usize * self.width as usize + u as usize])
    }

    /// Returns all pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = Depth> + '_ {
        self.depth.iter().copied().map(reading)
    }
}

fn reading(metres: f32) -> Depth {
    match metres {
        d if d.is_nan() => Depth::Missing,
        f32::INFINITY => Depth::Beyond,
        d => Depth::Surface(d),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_those_of_each_place_and_become_the_same_image() {
        let numbers = vec![0.5, f32::NAN, f32::INFINITY, 0.25, 2.0, f32::NAN];
        let image = DepthImage::from_metres(3, 2, numbers).unwrap();
        let places = (0..2).flat_map(|v| (0..3).map(move |u| (u, v)));
        assert!(image.pixels().eq(places.map(|(u, v)| image.get(u, v))));
        let again = DepthImage::from_metres(3, 2, image.pixels().map(Depth::metres).collect()).unwrap();
        assert!(image.pixels().eq(again.pixels()));
    }

    #[test]
    fn tells_missing_from_beyond() {
        let image = DepthImage::from_metres(5, 1, vec![0.5, 0.0, -1.0, f32::NAN, f32::INFINITY]).unwrap();
        let pixels: Vec<Depth> = (0..5).map(|u| image.get(u, 0)).collect();
        use Depth::*;
        assert_eq!(pixels, [Surface(0.5), Missing, Missing, Missing, Beyond]);
    }

    #[test]
    fn scales_raw_units() {
        let image = DepthImage::from_units(2, 1, &[0, 1500], 0.001).unwrap();
        assert_eq!((image.get(0, 0), image.get(1, 0)), (Depth::Missing, Depth::Surface(1.5)));
        assert!(DepthImage::from_units(2, 1, &[0, 0], 0.0).is_err());
        assert!(DepthImage::from_units(2, 2, &[0, 0], 0.001).is_err());
    }
}
