use super::chunk::{Chunk, LANES};
use super::pixel_box::PixelBox;
use super::samples::ImageSamples;

/// The nearest surface found at every sample, and bounds for square image tiles, which quickly identify
/// hidden parts (a two-level hierarchical z-buffer: Greene, Kass & Miller 1993).
pub(super) struct DepthBuffer {
    /// 1 / depth in the order of the samples: 0 where there is no surface, infinite where there is no sample.
    nearest: Vec<Chunk>,
    /// For each tile of [`LANES`] by [`LANES`] samples, a lower bound of its samples.
    tiles: Vec<f64>,
    chunks_in_row: usize,
}

impl DepthBuffer {
    /// Creates a buffer without surfaces.
    pub fn new(samples: &ImageSamples) -> Self {
        let chunks_in_row = samples.chunks_in_row();
        let n_tiles = chunks_in_row * samples.size()[1].div_ceil(LANES);
        Self { nearest: samples.blank().to_vec(), tiles: vec![0.0; n_tiles], chunks_in_row }
    }

    /// Returns 1 / depth of the nearest surface at every sample.
    #[inline(always)]
    pub fn nearest(&mut self) -> &mut [Chunk] {
        &mut self.nearest
    }

    /// Returns the samples and consumes the buffer.
    pub fn into_nearest(self) -> Vec<Chunk> {
        self.nearest
    }

    /// Returns whether all samples in a box, which must not be empty, show something nearer than 1 /
    /// `inverse_depth`.
    #[inline(always)]
    pub fn hides(&self, pixels: PixelBox, inverse_depth: f64) -> bool {
        let (columns, rows) = (pixels.columns(), pixels.rows());
        (rows.start / LANES..=(rows.end - 1) / LANES).all(|tile_row| {
            let row = &self.tiles[tile_row * self.chunks_in_row..][..self.chunks_in_row];
            row[columns.start / LANES..=(columns.end - 1) / LANES].iter().all(|&tile| tile > inverse_depth)
        })
    }

    /// Updates the bounds in a box, which must not be empty. Bounds that were not updated are still valid,
    /// but looser.
    #[inline(always)]
    pub fn update_bounds(&mut self, pixels: PixelBox) {
        let (columns, rows) = (pixels.columns(), pixels.rows());
        for tile_row in rows.start / LANES..=(rows.end - 1) / LANES {
            for tile_column in columns.start / LANES..=(columns.end - 1) / LANES {
                let mut lowest = [f64::INFINITY; LANES];
                let first_row = tile_row * LANES * self.chunks_in_row;
                let chunks = self.nearest[first_row + tile_column..].iter().step_by(self.chunks_in_row);
                for chunk in chunks.take(LANES) {
                    for (lowest, &nearest) in lowest.iter_mut().zip(chunk) {
                        *lowest = if nearest < *lowest { nearest } else { *lowest };
                    }
                }
                let tile = &mut self.tiles[tile_row * self.chunks_in_row + tile_column];
                *tile = lowest.into_iter().fold(f64::INFINITY, f64::min);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use nextview::geometry::random::Random;
    use nextview::sensor::Intrinsics;

    /// The brute-force reference checks all samples.
    #[test]
    fn hides_only_what_every_sample_hides() {
        let (width, height) = (43, 27);
        let camera = Intrinsics::pinhole(width, height, DVec2::splat(30.0), DVec2::splat(15.0)).unwrap();
        let mut buffer = DepthBuffer::new(&ImageSamples::new(&camera).unwrap());
        let mut random = Random::new(3, 0);
        let mut n_hidden = 0;
        for round in 0..2000 {
            let [left, top] = [width, height].map(|size| random.index(size as usize) as i32);
            let right = (left + 1 + random.index(12) as i32).min(width as i32);
            let bottom = (top + 1 + random.index(12) as i32).min(height as i32);
            let pixels = PixelBox::new([left, top], [right, bottom]);
            let in_box = |chunks: &mut [Chunk], work: &mut dyn FnMut(&mut f64)| {
                for row in pixels.rows() {
                    pixels.columns().for_each(|u| work(&mut chunks[row * 6 + u / LANES][u % LANES]));
                }
            };
            let inverse_depth = random.range(0.0, 1.0);
            let mut is_hidden = true;
            in_box(buffer.nearest(), &mut |nearest| is_hidden &= *nearest > inverse_depth);
            if buffer.hides(pixels, inverse_depth) {
                assert!(is_hidden, "{pixels:?}");
                n_hidden += 1;
            }
            in_box(buffer.nearest(), &mut |nearest| *nearest = nearest.max(inverse_depth));
            if round % 3 > 0 {
                buffer.update_bounds(pixels);
            }
        }
        assert!(n_hidden > 200, "{n_hidden}");
    }
}
