use super::lateral::Shifts;
use super::normal::normal;
use super::{DepthNoise, loss};
use nextview::geometry::random::Random;
use nextview::sensor::Intrinsics;

/// For every pixel the number of the pixel of the exact image whose depth it shows; none if it is lost.
pub(crate) struct Readings(Vec<Option<u32>>);

impl Readings {
    /// The readings of a camera with this noise in an exact image, depths in metres row by row.
    pub fn new(noise: &DepthNoise, exact: &[f32], intrinsics: &Intrinsics, random: &mut Random) -> Self {
        let loss = loss::probabilities(noise, exact, intrinsics);
        let shifts = Shifts::new(noise.lateral_sigma);
        let (width, height) = (intrinsics.width() as i32, intrinsics.height() as i32);
        let mut readings = Vec::with_capacity(exact.len());
        for v in 0..height {
            for u in 0..width {
                let [right, down] = [shifts.at(random.unit()), shifts.at(random.unit())];
                let (u, v) = ((u + right).clamp(0, width - 1), (v + down).clamp(0, height - 1));
                let pixel = (v * width + u) as u32;
                readings.push((random.unit() >= loss[pixel as usize] as f64).then_some(pixel));
            }
        }
        Self(readings)
    }

    /// The exact image with only the pixels that were read; all others are missing.
    pub fn truly_measured(&self, exact: &[f32]) -> Vec<f32> {
        let mut measured = vec![f32::NAN; exact.len()];
        for &pixel in self.0.iter().flatten() {
            measured[pixel as usize] = exact[pixel as usize];
        }
        measured
    }

    /// An exact image as it is read, without any error along the axis: every pixel shows the depth of the one
    /// it was read from.
    pub fn shown(&self, exact: &[f32]) -> Vec<f32> {
        self.0.iter().map(|reading| reading.map_or(f32::NAN, |pixel| exact[pixel as usize])).collect()
    }

    /// The image that the camera measures.
    pub fn reported(&self, noise: &DepthNoise, exact: &[f32], random: &mut Random) -> Vec<f32> {
        let told = |&reading: &Option<u32>| match reading {
            Some(pixel) => noise.reported(exact[pixel as usize] as f64, normal(random)),
            None => f32::NAN,
        };
        self.0.iter().map(told).collect()
    }
}
