use glam::DVec2;
use nextview::sensor::Intrinsics;

/// The image as a set of sample points in the ideal plane z = 1, one for each pixel centre, sorted into a regular
/// grid of cells so that the samples in a rectangle of that plane are found without knowing the lens.
///
/// The grid has as many cells as the image has pixels and spans all samples. Without distortion every cell holds
/// exactly its pixel's sample, in its middle.
pub(super) struct SampleGrid {
    size: [u16; 2],
    /// Ideal coordinates of the lower corner of the first cell.
    origin: DVec2,
    cells_per_unit: DVec2,
    /// What to add to a position in cells so that its whole part is the first cell that may hold a sample at or
    /// above it, and one past the last cell that may hold a sample at or below it. Knowing how far the samples
    /// stray from the middle of their cells keeps the ranges tight.
    first_shift: DVec2,
    end_shift: DVec2,
    /// `starts[c]..starts[c + 1]` are the samples of cell `c`, row by row.
    starts: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    pixel: Vec<u32>,
}

/// A rectangle of cells: `first` up to but without `end`, on each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellBox {
    pub first: [u16; 2],
    pub end: [u16; 2],
}

impl CellBox {
    /// Whether it holds no cell.
    pub fn is_empty(&self) -> bool {
        self.first[0] >= self.end[0] || self.first[1] >= self.end[1]
    }

    /// The smallest box that holds three others.
    pub fn around(a: Self, b: Self, c: Self) -> Self {
        let low = |axis: usize| a.first[axis].min(b.first[axis]).min(c.first[axis]);
        let high = |axis: usize| a.end[axis].max(b.end[axis]).max(c.end[axis]);
        Self { first: [low(0), low(1)], end: [high(0), high(1)] }
    }
}

impl SampleGrid {
    /// Slack in cells that covers the rounding of a position given in cells (at most 32768 of them).
    const SLACK: f64 = 1e-6;

    /// The samples of all pixels for which the lens model has an answer; none if it has no answer at all.
    pub fn new(intrinsics: &Intrinsics) -> Option<Self> {
        let samples = deprojected_pixels(intrinsics);
        let first = samples.first()?.1;
        let (low, high) = samples.iter().fold((first, first), |(l, h), (_, s)| (l.min(*s), h.max(*s)));
        // A side of at most 2^15 pixels fits.
        let size = [intrinsics.width() as u16, intrinsics.height() as u16];
        let n_gaps = DVec2::new(size[0] as f64 - 1.0, size[1] as f64 - 1.0);
        let spacing = (high - low) / n_gaps.max(DVec2::ONE);
        let pitch = DVec2::select(spacing.cmpgt(DVec2::ZERO), spacing, 1.0 / intrinsics.focal());
        let mut grid = Self {
            size,
            origin: low - 0.5 * pitch,
            cells_per_unit: 1.0 / pitch,
            first_shift: DVec2::ZERO,
            end_shift: DVec2::ONE,
            starts: Vec::new(),
            x: Vec::new(),
            y: Vec::new(),
            pixel: Vec::new(),
        };
        grid.fill(&samples);
        Some(grid)
    }

    /// All cells.
    pub fn all(&self) -> CellBox {
        CellBox { first: [0, 0], end: self.size }
    }

    /// The cells that may hold samples equal to an ideal point on either axis: the box of a point. The box of a
    /// polygon's corners, joined, holds every sample inside the polygon.
    #[inline]
    pub fn box_of(&self, ideal: DVec2) -> CellBox {
        let cells = (ideal - self.origin) * self.cells_per_unit;
        let (first, end) = (cells + self.first_shift, cells + self.end_shift);
        // Casts from float to integer cut off the fraction and stop at 0 and 65535.
        let clamped = |value: f64, axis: usize| (value as u16).min(self.size[axis]);
        CellBox {
            first: [clamped(first.x, 0), clamped(first.y, 1)],
            end: [clamped(end.x, 0), clamped(end.y, 1)],
        }
    }

    /// The range of samples in the cells of one row of a box.
    #[inline]
    pub fn in_row(&self, cells: CellBox, row: u16) -> std::ops::Range<usize> {
        let first_in_row = row as usize * self.size[0] as usize;
        let start = |column: u16| self.starts[first_in_row + column as usize] as usize;
        start(cells.first[0])..start(cells.end[0])
    }

    /// Ideal coordinates x and y of every sample.
    pub fn coordinates(&self) -> (&[f64], &[f64]) {
        (&self.x, &self.y)
    }

    /// The pixel of every sample, numbered row by row.
    pub fn pixels(&self) -> &[u32] {
        &self.pixel
    }

    /// Sorts the samples into their cells; those of one cell stay in the order of their pixels.
    fn fill(&mut self, samples: &[(u32, DVec2)]) {
        let n_cells = self.size[0] as usize * self.size[1] as usize;
        let (mut lowest, mut highest) = (DVec2::ONE, DVec2::ZERO);
        let mut cells = Vec::with_capacity(samples.len());
        for (_, ideal) in samples {
            let position = (*ideal - self.origin) * self.cells_per_unit;
            let last = DVec2::new(self.size[0] as f64 - 1.0, self.size[1] as f64 - 1.0);
            let cell = position.floor().clamp(DVec2::ZERO, last);
            lowest = lowest.min(position - cell);
            highest = highest.max(position - cell);
            cells.push(cell.y as usize * self.size[0] as usize + cell.x as usize);
        }
        self.first_shift = 1.0 - highest - Self::SLACK;
        self.end_shift = 1.0 - lowest + Self::SLACK;

        let mut order: Vec<u32> = (0..samples.len() as u32).collect();
        order.sort_by_key(|&i| cells[i as usize]);
        let sorted = || order.iter().map(|&i| samples[i as usize]);
        self.x = sorted().map(|(_, ideal)| ideal.x).collect();
        self.y = sorted().map(|(_, ideal)| ideal.y).collect();
        self.pixel = sorted().map(|(pixel, _)| pixel).collect();
        self.starts = vec![0; n_cells + 1];
        for cell in cells {
            self.starts[cell + 1] += 1;
        }
        for cell in 0..n_cells {
            self.starts[cell + 1] += self.starts[cell];
        }
    }
}

/// Pixel number and ideal point of every pixel centre that has one.
fn deprojected_pixels(intrinsics: &Intrinsics) -> Vec<(u32, DVec2)> {
    let width = intrinsics.width();
    (0..intrinsics.n_pixels() as u32)
        .filter_map(|i| {
            let pixel = DVec2::new((i % width) as f64, (i / width) as f64);
            intrinsics.deproject(pixel).filter(|ideal| ideal.is_finite()).map(|ideal| (i, ideal))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;
    use nextview::sensor::Distortion;

    fn pinhole(width: u32, height: u32) -> Intrinsics {
        Intrinsics::pinhole(width, height, DVec2::new(610.0, 590.0), DVec2::new(31.3, 20.9)).unwrap()
    }

    #[test]
    fn without_distortion_a_cell_is_a_pixel() {
        let camera = pinhole(64, 48);
        let grid = SampleGrid::new(&camera).unwrap();
        assert!(grid.pixels().iter().enumerate().all(|(i, &pixel)| i as u32 == pixel));
        let between = |u: f64, v: f64| grid.box_of(camera.deproject(DVec2::new(u, v)).unwrap());
        assert_eq!(
            between(10.3, 20.7),
            CellBox { first: [11, 21], end: [11, 21] },
            "no sample between pixels"
        );
        assert_eq!(between(10.0, 20.0), CellBox { first: [10, 20], end: [11, 21] }, "a sample on the pixel");
        assert_eq!(between(-9.0, 99.0), CellBox { first: [0, 48], end: [0, 48] }, "beyond the border");
    }

    /// The dumb twin: look at all samples.
    #[test]
    fn a_box_holds_every_sample_of_a_rectangle() {
        let strong = Distortion::BrownConrady([-0.2, 0.05, 0.01, -0.01, 0.0]);
        let wide = Intrinsics::pinhole(64, 48, DVec2::splat(40.0), DVec2::new(30.0, 25.0)).unwrap();
        let cameras = [
            pinhole(64, 48),
            pinhole(1, 1),
            pinhole(1, 9),
            Intrinsics::d435i(),
            wide.with_distortion(strong).unwrap(),
        ];
        let mut random = Random::new(1, 0);
        for camera in cameras {
            let grid = SampleGrid::new(&camera).unwrap();
            let (x, y) = grid.coordinates();
            for _ in 0..50 {
                let corner = |random: &mut Random| 0.7 * random.in_cube().truncate();
                let (a, b) = (corner(&mut random), corner(&mut random));
                let (low, high) = (a.min(b), a.max(b));
                let cells = CellBox::around(grid.box_of(a), grid.box_of(b), grid.box_of(b));
                let mut found: Vec<usize> =
                    (cells.first[1]..cells.end[1]).flat_map(|row| grid.in_row(cells, row)).collect();
                found.retain(|&s| inside(DVec2::new(x[s], y[s]), low, high));
                let expected: Vec<usize> =
                    (0..x.len()).filter(|&s| inside(DVec2::new(x[s], y[s]), low, high)).collect();
                assert_eq!(found, expected);
            }
        }
    }

    fn inside(point: DVec2, low: DVec2, high: DVec2) -> bool {
        point.cmpge(low).all() && point.cmple(high).all()
    }
}
