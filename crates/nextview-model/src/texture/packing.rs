//! The layout of charts in the texture.

use super::charts::Chart;
use super::sight::PhotoSight;
use glam::DVec2;
use nextview::Error;

/// Padding around each chart, pixels.
pub(super) const PAD: usize = 2;

/// The parts of a texture.
pub(super) struct TextureLayout {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Pixels of the texture per pixel of a photo.
    pub scale: f64,
    /// By chart, the position, width and height of its rectangle.
    pub rectangles: Vec<[usize; 4]>,
    /// By chart, the position in its photo that lies [`PAD`] pixels from the corner of the rectangle.
    pub origins: Vec<DVec2>,
    /// The position of the cells of unseen triangles, their number per row, and the width of each.
    pub unseen: [usize; 4],
}

impl TextureLayout {
    /// Returns a layout at the scale of the photos, or the largest that fits into a square of this side.
    pub fn new(
        charts: &[Chart],
        sights: &[PhotoSight],
        n_unseen: usize,
        max_side: usize,
    ) -> Result<Self, Error> {
        let extents: Vec<(DVec2, DVec2)> =
            charts.iter().map(|chart| extent(chart, &sights[chart.photo])).collect();
        // Four by four pixels, or one if these would take more than a quarter.
        let cell = if 16 * n_unseen <= max_side * max_side / 4 { 4 } else { 1 };
        let n_side = (n_unseen as f64).sqrt().ceil() as usize;
        let mut scale = 1.0;
        while scale > 1e-3 {
            let sizes = extents.iter().map(|(low, high)| {
                let size = (scale * (*high - *low)).ceil();
                [size.x as usize + 1 + 2 * PAD, size.y as usize + 1 + 2 * PAD]
            });
            let n_rows = n_unseen.div_ceil(n_side.max(1));
            let sizes: Vec<[usize; 2]> = sizes.chain([[n_side * cell, n_rows * cell]]).collect();
            let (size, mut places) = pack(&sizes);
            if size.iter().all(|side| *side <= max_side) {
                let [x, y] = places.pop().unwrap_or_default();
                let rectangles = places.iter().zip(&sizes).map(|([x, y], [w, h])| [*x, *y, *w, *h]).collect();
                let origins = extents.into_iter().map(|(low, _)| low).collect();
                return Ok(Self { size, scale, rectangles, origins, unseen: [x, y, n_side, cell] });
            }
            scale *= 0.9;
        }
        let value = format!("{} charts and {n_unseen} triangles that no photo sees", charts.len());
        Err(Error::invalid("mesh", value, "fewer: they do not fit into a texture"))
    }
}

/// Returns the pixels of the photo covered by a chart, beginning at a whole pixel.
fn extent(chart: &Chart, sight: &PhotoSight) -> (DVec2, DVec2) {
    let pixels = chart.vertices.iter().filter_map(|vertex| sight.places[*vertex as usize]);
    let around = |(low, high): (DVec2, DVec2), pixel: DVec2| (low.min(pixel), high.max(pixel));
    let (low, high) = pixels.map(|place| place.pixel).fold((DVec2::INFINITY, DVec2::NEG_INFINITY), around);
    (low.floor(), high)
}

/// Packs rectangles on shelves, the highest first. Returns the total size, at least one pixel, and the
/// position of each.
fn pack(sizes: &[[usize; 2]]) -> ([usize; 2], Vec<[usize; 2]>) {
    let area: usize = sizes.iter().map(|[width, height]| width * height).sum();
    let widest = sizes.iter().map(|size| size[0]).max().unwrap_or(0);
    let width = widest.max((1.1 * area as f64).sqrt().ceil() as usize).max(1);
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(sizes[*i][1]), *i));
    let mut places = vec![[0; 2]; sizes.len()];
    let (mut x, mut y, mut shelf) = (0, 0, 0);
    for i in order {
        let [w, h] = sizes[i];
        if x + w > width {
            (x, y, shelf) = (0, y + shelf, 0);
        }
        places[i] = [x, y];
        (x, shelf) = (x + w, shelf.max(h));
    }
    ([width, (y + shelf).max(1)], places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// The slow twin: a count of every pixel.
    #[test]
    fn no_two_rectangles_overlap() {
        let mut random = Random::new(5, 0);
        for n in [0, 1, 2, 30, 200] {
            let sizes: Vec<[usize; 2]> = (0..n).map(|_| [random.index(40), random.index(60)]).collect();
            let ([width, height], places) = pack(&sizes);
            let mut count = vec![0; width * height];
            for ([x, y], [w, h]) in places.iter().zip(&sizes) {
                (*y..y + h)
                    .for_each(|v| count[v * width + x..v * width + x + w].iter_mut().for_each(|n| *n += 1));
            }
            assert!(count.iter().all(|n| *n <= 1), "{n} rectangles");
            let area: usize = sizes.iter().map(|[w, h]| w * h).sum();
            assert_eq!(count.iter().sum::<usize>(), area);
            assert!(n < 200 || width * height < 2 * area, "{width} x {height} for {area}");
        }
    }
}
