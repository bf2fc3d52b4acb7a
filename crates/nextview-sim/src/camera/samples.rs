use super::chunk::{Chunk, LANES};
use super::locator::PixelLocator;
use glam::DVec2;
use nextview::sensor::Intrinsics;

/// The image as sample points in the ideal plane z = 1, one per pixel centre, row by row in chunks.
pub(super) struct ImageSamples {
    size: [usize; 2],
    chunks_in_row: usize,
    /// Ideal coordinates. NaN, which is in no triangle, for pixels without an answer of the lens model and
    /// for the padding of a row's last chunk.
    x: Vec<Chunk>,
    y: Vec<Chunk>,
    blank: Vec<Chunk>,
    locator: PixelLocator,
}

impl ImageSamples {
    /// The samples of all pixels; `None` if the lens model has no answer for any pixel.
    pub fn new(intrinsics: &Intrinsics) -> Option<Self> {
        let size = [intrinsics.width() as usize, intrinsics.height() as usize];
        let chunks_in_row = size[0].div_ceil(LANES);
        let nowhere = vec![[f64::NAN; LANES]; chunks_in_row * size[1]];
        let (mut x, mut y) = (nowhere.clone(), nowhere);
        let mut blank = vec![[f64::INFINITY; LANES]; x.len()];
        let mut known = Vec::new();
        for row in 0..size[1] {
            for column in 0..size[0] {
                let pixel = DVec2::new(column as f64, row as f64);
                if let Some(ideal) = intrinsics.deproject(pixel).filter(|ideal| ideal.is_finite()) {
                    let chunk = row * chunks_in_row + column / LANES;
                    (x[chunk][column % LANES], y[chunk][column % LANES]) = (ideal.x, ideal.y);
                    blank[chunk][column % LANES] = 0.0;
                    known.push((pixel, ideal));
                }
            }
        }
        let locator = PixelLocator::new(intrinsics, &known)?;
        Some(Self { size, chunks_in_row, x, y, blank, locator })
    }

    /// Returns the width and height of the image in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the number of chunks in an image row.
    pub fn chunks_in_row(&self) -> usize {
        self.chunks_in_row
    }

    /// Returns ideal coordinates x of all samples.
    pub fn x(&self) -> &[Chunk] {
        &self.x
    }

    /// Returns ideal coordinates y of all samples.
    pub fn y(&self) -> &[Chunk] {
        &self.y
    }

    /// Returns the ideal points of all pixels row by row, NaN for those without an answer.
    pub fn ideal_points(&self) -> impl Iterator<Item = DVec2> + '_ {
        let rows = self.x.chunks_exact(self.chunks_in_row).zip(self.y.chunks_exact(self.chunks_in_row));
        rows.flat_map(|(x, y)| {
            let points = x.as_flattened().iter().zip(y.as_flattened());
            points.take(self.size[0]).map(|(&x, &y)| DVec2::new(x, y))
        })
    }

    /// Returns 0 for every sample and infinity where there is none.
    pub fn blank(&self) -> &[Chunk] {
        &self.blank
    }

    /// Finds the samples in a region of the ideal plane.
    pub fn locator(&self) -> &PixelLocator {
        &self.locator
    }
}
