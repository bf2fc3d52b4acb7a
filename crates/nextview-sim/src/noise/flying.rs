//! Pixels that see two surfaces at once, as in time-of-flight cameras.

use super::SensorNoise;
use nextview::geometry::random::Random;

/// A pixel with light from both sides of an edge; its depth lies between theirs.
pub(super) struct FlyingPixel {
    /// The pixel.
    pub pixel: u32,
    /// The pixels of the exact image on both sides.
    pub sides: [u32; 2],
    /// Share of the light from the second side, 0..1.
    pub share: f32,
}

impl FlyingPixel {
    /// Returns the depth between those of both sides in an exact image.
    pub fn depth(&self, exact: &[f32]) -> f32 {
        let [first, second] = self.sides.map(|side| exact[side as usize]);
        first + self.share * (second - first)
    }

    /// Returns the nearer depth of both sides.
    pub fn nearest(&self, exact: &[f32]) -> f32 {
        let [first, second] = self.sides.map(|side| exact[side as usize]);
        first.min(second)
    }
}

/// The flying pixels among those that show the depth of these pixels of the exact image, `width` wide.
pub(super) fn flying(
    noise: &SensorNoise,
    exact: &[f32],
    width: usize,
    readings: &[Option<u32>],
    random: &mut Random,
) -> Vec<FlyingPixel> {
    let pixels = readings.iter().enumerate().filter_map(|(pixel, reading)| Some((pixel, (*reading)?)));
    let at_edges = pixels
        .filter_map(|(pixel, side)| Some((pixel, side, other_side(noise, exact, width, side as usize)?)));
    at_edges
        .filter_map(|(pixel, side, other)| {
            let [lot, share] = [random.unit(), random.unit()];
            let sides = [side, other as u32];
            (lot < noise.flying_share).then_some(FlyingPixel {
                pixel: pixel as u32,
                sides,
                share: share as f32,
            })
        })
        .collect()
}

/// The neighbour across an edge with the largest difference in depth; `None` if the pixel is not at an edge.
fn other_side(noise: &SensorNoise, exact: &[f32], width: usize, pixel: usize) -> Option<usize> {
    let column = pixel % width;
    let neighbours = [
        (column > 0).then(|| pixel - 1),
        (column + 1 < width).then_some(pixel + 1),
        pixel.checked_sub(width),
        Some(pixel + width),
    ];
    let here = exact[pixel];
    let step = |other: &usize| (exact[*other] - here).abs();
    let is_seen = |other: &usize| exact.get(*other).is_some_and(|depth| *depth <= noise.max_depth as f32);
    let is_jump = |other: &usize| step(other) > noise.flying_jump as f32 * here.min(exact[*other]);
    let across = neighbours.into_iter().flatten().filter(is_seen).filter(is_jump);
    across.max_by(|a, b| step(a).total_cmp(&step(b)))
}
