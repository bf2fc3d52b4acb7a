use super::flying::{FlyingPixel, flying};
use super::lateral::Shifts;
use super::normal::normal;
use super::waves::Waves;
use super::{SensorNoise, loss};
use nextview::geometry::random::Random;
use nextview::sensor::Intrinsics;

/// The source of the depth of each pixel of an image.
pub(crate) struct Readings {
    /// The index of the exact image's pixel whose depth it shows; `None` if it is lost or flies.
    pixels: Vec<Option<u32>>,
    /// Pixels between two depths, which measure no surface.
    flying: Vec<FlyingPixel>,
}

impl Readings {
    /// The readings of a camera with this noise in an exact image, depths in metres row by row, without
    /// flying pixels.
    pub fn new(noise: &SensorNoise, exact: &[f32], intrinsics: &Intrinsics, random: &mut Random) -> Self {
        let loss = loss::probabilities(noise, exact, intrinsics);
        let shifts = Shifts::new(noise.lateral_sigma);
        let (width, height) = (intrinsics.width() as i32, intrinsics.height() as i32);
        let mut pixels = Vec::with_capacity(exact.len());
        for v in 0..height {
            for u in 0..width {
                let [right, down] = [shifts.at(random.unit()), shifts.at(random.unit())];
                let (u, v) = ((u + right).clamp(0, width - 1), (v + down).clamp(0, height - 1));
                let pixel = (v * width + u) as u32;
                pixels.push((random.unit() >= loss[pixel as usize] as f64).then_some(pixel));
            }
        }
        Self { pixels, flying: Vec::new() }
    }

    /// Adds flying pixels, if the noise has any, in an image of this width.
    pub fn with_flying(
        mut self,
        noise: &SensorNoise,
        exact: &[f32],
        width: u32,
        random: &mut Random,
    ) -> Self {
        if noise.flying_share > 0.0 {
            self.flying = flying(noise, exact, width as usize, &self.pixels, random);
            self.flying.iter().for_each(|flying| self.pixels[flying.pixel as usize] = None);
        }
        self
    }

    /// The exact image with only the pixels read; all others are missing.
    pub fn truly_measured(&self, exact: &[f32]) -> Vec<f32> {
        let mut measured = vec![f32::NAN; exact.len()];
        for &pixel in self.pixels.iter().flatten() {
            measured[pixel as usize] = exact[pixel as usize];
        }
        measured
    }

    /// An exact image without axial error: every pixel shows the depth of the pixel it was read from; a
    /// flying pixel shows the nearer of its two.
    pub fn shown(&self, exact: &[f32]) -> Vec<f32> {
        self.image(|pixel| exact[pixel as usize], |flying| flying.nearest(exact))
    }

    /// The measured image, with the errors that pixels share, if any.
    pub fn reported(
        &self,
        noise: &SensorNoise,
        exact: &[f32],
        waves: Option<&Waves>,
        random: &mut Random,
    ) -> Vec<f32> {
        let depth = self.image(|pixel| exact[pixel as usize], |flying| flying.depth(exact));
        let told = |(pixel, depth): (usize, f32)| {
            if depth.is_nan() {
                return depth;
            }
            let own = normal(random);
            noise.reported(depth as f64, waves.map_or(own, |waves| waves.error(pixel, own)))
        };
        depth.into_iter().enumerate().map(told).collect()
    }

    /// The image of the pixels' values, NaN where they are lost.
    fn image(&self, read: impl Fn(u32) -> f32, between: impl Fn(&FlyingPixel) -> f32) -> Vec<f32> {
        let shown = self.pixels.iter().map(|reading| reading.map_or(f32::NAN, &read));
        let mut image: Vec<f32> = shown.collect();
        self.flying.iter().for_each(|flying| image[flying.pixel as usize] = between(flying));
        image
    }
}
