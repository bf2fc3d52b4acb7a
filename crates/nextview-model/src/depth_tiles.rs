//! Common properties of the pixels in a part of an image.

use std::ops::RangeInclusive;

/// Side of a tile, pixels.
const SIDE: usize = 8;

/// The depths of an image, summarised by squares of pixels.
pub(super) struct DepthTiles {
    width: usize,
    height: usize,
    tiles: Vec<TileSummary>,
}

/// A summary of the pixels of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileSummary {
    /// Lower bound of the depth.
    pub least: f32,
    /// Upper bound of the depth.
    pub most: f32,
    /// Whether all pixels are without return.
    pub all_open: bool,
    /// Whether some pixel is without return.
    pub any_open: bool,
}

impl TileSummary {
    const NOTHING: Self =
        Self { least: f32::INFINITY, most: f32::NEG_INFINITY, all_open: true, any_open: false };

    fn and(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
            all_open: self.all_open && other.all_open,
            any_open: self.any_open || other.any_open,
        }
    }
}

impl DepthTiles {
    /// Builds the tiles from each pixel's depth and whether it is without return, row by row.
    pub(super) fn new(depth: &[f32], is_open: &[bool], width: usize) -> Self {
        let pixels = depth.iter().zip(is_open);
        let n_tiles = width.div_ceil(SIDE) * (depth.len() / width).div_ceil(SIDE);
        let mut tiles =
            Self { width, height: depth.len() / width, tiles: vec![TileSummary::NOTHING; n_tiles] };
        for (pixel, (&depth, &is_open)) in pixels.enumerate() {
            let tile = tiles.index(pixel % width / SIDE, pixel / width / SIDE);
            let here = TileSummary { least: depth, most: depth, all_open: is_open, any_open: is_open };
            tiles.tiles[tile] = tiles.tiles[tile].and(here);
        }
        tiles
    }

    /// Returns the summary of the pixels in these columns and rows, which may extend beyond the image: that
    /// of all tiles that they touch.
    pub(super) fn extent(&self, columns: RangeInclusive<usize>, rows: RangeInclusive<usize>) -> TileSummary {
        let tiles =
            |range: RangeInclusive<usize>, n: usize| range.start() / SIDE..=(*range.end()).min(n - 1) / SIDE;
        let columns = tiles(columns, self.width);
        let rows = tiles(rows, self.height).flat_map(|row| columns.clone().map(move |column| (column, row)));
        rows.fold(TileSummary::NOTHING, |extent, (column, row)| {
            extent.and(self.tiles[self.index(column, row)])
        })
    }

    fn index(&self, column: usize, row: usize) -> usize {
        row * self.width.div_ceil(SIDE) + column
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// The slow twin: every pixel, of the window and of the whole tiles.
    #[test]
    fn an_extent_holds_all_pixels_of_the_window_and_none_beyond_its_tiles() {
        let mut random = Random::new(7, 0);
        for (width, height) in [(1, 1), (8, 8), (21, 17), (40, 9)] {
            let depth: Vec<f32> = (0..width * height).map(|_| random.unit() as f32).collect();
            let is_open: Vec<bool> = depth.iter().map(|depth| *depth < 0.02 || *depth > 0.5).collect();
            let tiles = DepthTiles::new(&depth, &is_open, width);
            for _ in 0..200 {
                let mut range = |n: usize| {
                    let first = (random.unit() * n as f64) as usize;
                    first..=first + (random.unit() * 12.0) as usize
                };
                let (columns, rows) = (range(width), range(height));
                let within = |columns: &RangeInclusive<usize>, rows: &RangeInclusive<usize>| {
                    let inside = |i: &usize| columns.contains(&(i % width)) && rows.contains(&(i / width));
                    let pixels = (0..depth.len()).filter(inside);
                    pixels.fold(TileSummary::NOTHING, |extent, i| {
                        let open = is_open[i];
                        extent.and(TileSummary {
                            least: depth[i],
                            most: depth[i],
                            all_open: open,
                            any_open: open,
                        })
                    })
                };
                let whole = |range: &RangeInclusive<usize>| {
                    range.start() / SIDE * SIDE..=range.end() / SIDE * SIDE + SIDE - 1
                };
                let found = tiles.extent(columns.clone(), rows.clone());
                assert_eq!(found, within(&whole(&columns), &whole(&rows)));
                assert_eq!(found, found.and(within(&columns, &rows)));
            }
        }
    }
}
