use super::SensorNoise;
use super::normal::normal;
use nextview::geometry::random::Random;
use nextview::sensor::Intrinsics;

/// The error that neighbouring pixels share: a smooth random field over the image. Each value is normally
/// distributed with variance 1; two values at a distance of r pixels correlate by exp(-r^2 / length^2).
///
/// Normal numbers on a grid with a spacing of half the length are smoothed by Gaussian bells of that width,
/// first along rows and then along columns (process convolution, Higdon 2002). Bells as wide as the grid
/// spacing leave no trace of the grid: their squares add up to a constant within 1e-4.
pub(crate) struct Waves {
    /// One value per pixel, row by row.
    values: Vec<f32>,
    /// Weights of a pixel's own error and of the wave's; their squares add up to 1.
    own: f64,
    shared: f64,
}

impl Waves {
    /// The waves of an image; `None` if the noise has no correlation.
    pub fn new(noise: &SensorNoise, intrinsics: &Intrinsics, random: &mut Random) -> Option<Self> {
        if noise.correlated_share == 0.0 {
            return None;
        }
        let [width, height] = [intrinsics.width(), intrinsics.height()].map(|size| size as usize);
        let [columns, rows] = [width, height].map(|size| Bells::new(size, noise.correlation));
        let grid: Vec<Vec<f32>> = (0..rows.n_nodes)
            .map(|_| (0..columns.n_nodes).map(|_| normal(random) as f32).collect())
            .map(|nodes: Vec<f32>| (0..width).map(|u| columns.at(u, |node| nodes[node])).collect())
            .collect();
        let values = (0..height).flat_map(|v| rows.mixed(v, &grid)).collect();
        let share = noise.correlated_share;
        Some(Self { values, own: (1.0 - share).sqrt(), shared: share.sqrt() })
    }

    /// The error of a pixel, in sigmas, given its own.
    pub fn error(&self, pixel: usize, own: f64) -> f64 {
        self.own * own + self.shared * self.values[pixel] as f64
    }
}

/// Number of bells at a pixel: those whose centre is nearer than four times their width.
const N_BELLS: usize = 8;

/// Gaussian bells along an axis of the image.
struct Bells {
    n_nodes: usize,
    /// For each pixel, the first of the nodes that reach it, and the weight of each node; the squares of the
    /// weights add up to 1.
    pixels: Vec<(usize, [f32; N_BELLS])>,
}

impl Bells {
    fn new(n_pixels: usize, length: f64) -> Self {
        let width = length / 2.0;
        let pixels: Vec<_> = (0..n_pixels)
            .map(|pixel| {
                let at = pixel as f64 / width;
                // Three nodes precede the last one that is not beyond the pixel.
                let bell = |k: usize| (-0.5 * (k as f64 - 3.0 - at.fract()).powi(2)).exp();
                let bells: [f64; N_BELLS] = std::array::from_fn(bell);
                let norm = bells.iter().map(|bell| bell * bell).sum::<f64>().sqrt();
                (at as usize, bells.map(|bell| (bell / norm) as f32))
            })
            .collect();
        let n_nodes = pixels.last().map_or(0, |(first, _)| first + N_BELLS);
        Self { n_nodes, pixels }
    }

    /// The weighted sum of the nodes' values for a pixel.
    fn at(&self, pixel: usize, value: impl Fn(usize) -> f32) -> f32 {
        let (first, weights) = &self.pixels[pixel];
        weights.iter().enumerate().map(|(k, weight)| weight * value(first + k)).sum()
    }

    /// The weighted sum of whole rows.
    fn mixed(&self, pixel: usize, rows: &[Vec<f32>]) -> Vec<f32> {
        let (first, weights) = &self.pixels[pixel];
        let mut sum = vec![0.0; rows[0].len()];
        for (row, weight) in rows[*first..].iter().zip(weights) {
            sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }
}
