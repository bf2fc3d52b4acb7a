//! Minimum depth around each pixel.

use nextview::{Cancel, Cancelled};
use rayon::prelude::*;

/// The depth up to which a pixel and those around it are free, in square windows up to a maximum size.
///
/// The minimum of a window is that of four windows at its corners, each at least half as wide. Half-widths 0,
/// 1, 2, 4, 8, ... are therefore enough: with every half-width up to 32, a frame took 132 bytes a pixel, most
/// of the memory of a scan.
pub(super) struct ClearDepth {
    width: usize,
    height: usize,
    /// Row by row, for half-widths 0, 1, 2, 4, 8, ...
    levels: Vec<Vec<f32>>,
    max_half_width: usize,
}

impl ClearDepth {
    /// Builds the windows from the depth of each pixel, row by row.
    pub(super) fn new(
        depth: Vec<f32>,
        width: usize,
        max_half_width: usize,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let height = depth.len() / width;
        let mut clear = Self { width, height, levels: vec![depth], max_half_width };
        if max_half_width > 0 {
            clear.levels.push(eroded(&clear.levels[0], width));
        }
        while 1 << (clear.levels.len() - 1) <= max_half_width {
            cancel.check()?;
            clear.levels.push(clear.doubled());
        }
        Ok(clear)
    }

    /// Returns the half-width of the largest window.
    pub(super) fn max_half_width(&self) -> usize {
        self.max_half_width
    }

    /// Returns the minimum depth in the window of this half-width, at most the largest, around a pixel.
    pub(super) fn around(&self, pixel: usize, half_width: usize) -> f32 {
        if half_width == 0 {
            return self.levels[0][pixel];
        }
        let level = half_width.ilog2() as usize;
        let apart = half_width - (1 << level);
        self.least_of_four(&self.levels[level + 1], pixel % self.width, pixel / self.width, apart)
    }

    /// Returns the windows twice as wide as the last ones.
    fn doubled(&self) -> Vec<f32> {
        let last = &self.levels[self.levels.len() - 1];
        let apart = 1 << (self.levels.len() - 2);
        let mut doubled = vec![0.0; last.len()];
        doubled.par_chunks_mut(self.width).enumerate().for_each(|(v, row)| {
            row.iter_mut().enumerate().for_each(|(u, value)| *value = self.least_of_four(last, u, v, apart));
        });
        doubled
    }

    /// Returns the minimum of the four windows whose centres are this many pixels away in both directions. At
    /// the border, windows are moved into the image, which cuts them off.
    fn least_of_four(&self, level: &[f32], u: usize, v: usize, apart: usize) -> f32 {
        let [left, right] = [u.saturating_sub(apart), (u + apart).min(self.width - 1)];
        let [top, bottom] = [v.saturating_sub(apart), (v + apart).min(self.height - 1)];
        let least = |v: usize| level[v * self.width + left].min(level[v * self.width + right]);
        least(top).min(least(bottom))
    }
}

/// Returns the smallest value among each pixel and its eight neighbours.
fn eroded(image: &[f32], width: usize) -> Vec<f32> {
    let (mut in_rows, mut result) = (image.to_vec(), image.to_vec());
    in_rows.par_chunks_mut(width).zip(image.par_chunks(width)).for_each(|(to, from)| {
        keep_smaller(&mut to[1..], from);
        keep_smaller(to, &from[1..]);
    });
    result.par_chunks_mut(width).enumerate().for_each(|(v, to)| {
        let rows = in_rows.chunks(width).skip(v.saturating_sub(1)).take(if v == 0 { 2 } else { 3 });
        rows.for_each(|row| keep_smaller(to, row));
    });
    result
}

fn keep_smaller(values: &mut [f32], others: &[f32]) {
    values.iter_mut().zip(others).for_each(|(value, other)| *value = value.min(*other));
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// The slow twin: all nine.
    #[test]
    fn erosion_takes_the_smallest_of_nine() {
        for (width, height) in [(1, 1), (1, 4), (5, 1), (2, 2), (7, 5)] {
            let image: Vec<f32> = (0..width * height).map(|i| (i * 37 % 23) as f32).collect();
            let expected: Vec<f32> = (0..width * height)
                .map(|i| {
                    let near = |j: &usize| {
                        (j % width).abs_diff(i % width) <= 1 && (j / width).abs_diff(i / width) <= 1
                    };
                    (0..width * height).filter(near).map(|j| image[j]).fold(f32::INFINITY, f32::min)
                })
                .collect();
            assert_eq!(eroded(&image, width), expected, "{width} x {height}");
        }
    }

    /// The slow twin: every pixel of every window.
    #[test]
    fn every_window_holds_its_least_value() {
        let mut random = Random::new(3, 0);
        for (width, height, max) in [(1, 1, 3), (7, 1, 2), (1, 9, 32), (11, 8, 5), (40, 23, 32), (5, 5, 0)] {
            let image: Vec<f32> = (0..width * height).map(|_| random.unit() as f32).collect();
            let clear = ClearDepth::new(image.clone(), width, max, &Cancel::default()).unwrap();
            for (pixel, n) in (0..image.len()).flat_map(|pixel| (0..=max).map(move |n| (pixel, n))) {
                let near = |other: &usize| {
                    let [a, b] = [pixel, *other].map(|i| [i % width, i / width]);
                    a[0].abs_diff(b[0]) <= n && a[1].abs_diff(b[1]) <= n
                };
                let least = (0..image.len()).filter(near).map(|i| image[i]).fold(f32::MAX, f32::min);
                assert_eq!(clear.around(pixel, n), least, "{width} x {height}, pixel {pixel}, {n} around");
            }
        }
    }
}
