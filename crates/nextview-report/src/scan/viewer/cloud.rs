//! The measured points in few bytes: an even choice of them, each coordinate in 16 bits.

use crate::scan::input::ScanPage;
use crate::text;
use base64::prelude::{BASE64_STANDARD, Engine};
use glam::Vec3;

/// Maximum number of points on a page. A point costs 8 characters, so they take 1.2 MB.
const MAX_POINTS: usize = 150_000;

/// Points of all views, view after view.
#[derive(Debug, PartialEq)]
pub(super) struct Cloud {
    /// Three little-endian 16-bit numbers per point, in base64.
    pub data: String,
    /// For each view, the number of points of all views up to it.
    pub ends: Vec<usize>,
    /// Lowest corner of the points, metres.
    pub min: Vec3,
    /// Size of one unit along each axis, metres: 15 micrometres for an object of 1 m.
    pub unit: Vec3,
    /// Corners of the box without the outer hundredth of the points on each side, in which stray ones lie.
    pub core: [Vec3; 2],
}

/// Packs the points of all steps; points that are not finite are left out.
pub(super) fn pack(page: &ScanPage<'_>) -> Cloud {
    let finite = |i| page.points(i).iter().copied().filter(|p| p.is_finite()).collect::<Vec<_>>();
    let views: Vec<Vec<Vec3>> = (0..page.steps().len()).map(finite).collect();
    packed(&views)
}

fn packed(views: &[Vec<Vec3>]) -> Cloud {
    let n_measured = views.iter().map(Vec::len).sum();
    let (points, ends) = choose(views, n_measured);
    let min = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let max = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
    let unit = (max - min) / u16::MAX as f32;
    Cloud { data: quantise(&points, min, unit), ends, min, unit, core: core(&points) }
}

/// A sentence for the reader if not all points are shown.
pub(in crate::scan) fn note(page: &ScanPage<'_>) -> String {
    let n_measured = page.n_points();
    if n_measured <= MAX_POINTS {
        return String::new();
    }
    format!("Shown are {} of {} points.", text::count(MAX_POINTS), text::count(n_measured))
}

/// One point out of each run of equal length, at a place that looks random: a fixed place would show the
/// pixel grid of the camera as stripes.
fn choose(views: &[Vec<Vec3>], n_measured: usize) -> (Vec<Vec3>, Vec<usize>) {
    let n_shown = n_measured.min(MAX_POINTS);
    let mut points = Vec::with_capacity(n_shown);
    let mut ends = Vec::with_capacity(views.len());
    let mut picks = (0..n_shown).map(|i| pick(i, n_shown, n_measured)).peekable();
    let mut start = 0;
    for view in views {
        let end = start + view.len();
        while let Some(i) = picks.next_if(|&i| i < end) {
            points.push(view[i - start]);
        }
        ends.push(points.len());
        start = end;
    }
    (points, ends)
}

/// The index taken from run `i` of `n_runs` runs over `n` points; increasing in `i`.
fn pick(i: usize, n_runs: usize, n: usize) -> usize {
    let (start, end) = (i * n / n_runs, (i + 1) * n / n_runs);
    // Multiplicative hashing with 2^64 over the golden ratio; the upper half of the product is well mixed.
    let hash = (i as u64 + 1)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .rotate_left(32)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15);
    start + (((hash >> 32) * (end - start) as u64) >> 32) as usize
}

fn quantise(points: &[Vec3], min: Vec3, unit: Vec3) -> String {
    let mut bytes = Vec::with_capacity(6 * points.len());
    for point in points {
        for axis in 0..3 {
            // A flat cloud has a unit of 0 and gives 0 / 0, which converts to 0.
            let steps = ((point[axis] - min[axis]) / unit[axis]).round() as u16;
            bytes.extend(steps.to_le_bytes());
        }
    }
    BASE64_STANDARD.encode(bytes)
}

fn core(points: &[Vec3]) -> [Vec3; 2] {
    let mut corners = [Vec3::ZERO; 2];
    for axis in 0..3 {
        let mut values: Vec<f32> = points.iter().map(|p| p[axis]).collect();
        values.sort_by(f32::total_cmp);
        if let Some(last) = values.len().checked_sub(1) {
            corners[0][axis] = values[last / 100];
            corners[1][axis] = values[last - last / 100];
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_are_all_kept_and_many_are_thinned_evenly() {
        assert!((0..1000).all(|i| pick(i, 1000, 1000) == i));
        let picks: Vec<usize> = (0..1000).map(|i| pick(i, 1000, 7300)).collect();
        assert!(picks.is_sorted_by(|a, b| a < b) && picks[999] < 7300);
        let in_first_half = picks.iter().filter(|&&p| p < 3650).count();
        assert_eq!(in_first_half, 500);
        let offsets: Vec<usize> = (0..1000).map(|i| picks[i] - i * 7300 / 1000).collect();
        assert!((0..7).all(|o| offsets.iter().filter(|&&x| x == o).count() > 90), "places in a run are even");
    }

    #[test]
    fn quantised_points_come_back() {
        let points = [Vec3::new(-1.0, 2.0, 0.5), Vec3::new(0.0, 2.0, 0.75), Vec3::new(1.0, 2.0, 1.0)];
        let (min, unit) = (points[0], Vec3::new(2.0, 0.0, 0.5) / 65535.0);
        let bytes = BASE64_STANDARD.decode(quantise(&points, min, unit)).unwrap();
        let numbers: Vec<u16> = bytes.chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        assert_eq!(numbers, [0, 0, 0, 32768, 0, 32768, 65535, 0, 65535]);
    }

    #[test]
    fn nothing_measured_is_no_fault() {
        let cloud = packed(&[]);
        assert_eq!((cloud.data, cloud.ends), (String::new(), vec![]));
    }
}
