//! The measured points in few bytes: an even selection, with 16 bits per coordinate.

use super::pack::PackedPositions;
use crate::scan::input::ScanPage;
use crate::text;
use glam::Vec3;
use std::ops::Range;

/// Maximum number of points on a page. A point costs 8 characters, so they take 0.8 MB.
pub(in crate::scan) const MAX_POINTS: usize = 100_000;

/// Points of views, view after view.
#[derive(Debug, PartialEq)]
pub(super) struct ViewerCloud {
    pub points: PackedPositions,
    /// For each view, the number of points of all views up to it.
    pub ends: Vec<usize>,
    /// Corners of the box around all points except the outermost hundredth on each side, which contains stray
    /// points.
    pub core: [Vec3; 2],
}

/// Packs at most `max_points` points of these steps; points that are not finite are left out.
pub(super) fn pack(page: &ScanPage<'_>, steps: Range<usize>, max_points: usize) -> ViewerCloud {
    let finite = |i| page.points(i).iter().copied().filter(|p| p.is_finite()).collect::<Vec<_>>();
    packed(&steps.map(finite).collect::<Vec<_>>(), max_points)
}

fn packed(views: &[Vec<Vec3>], max_points: usize) -> ViewerCloud {
    let n_measured = views.iter().map(Vec::len).sum();
    let (points, ends) = choose(views, n_measured, max_points);
    ViewerCloud { points: PackedPositions::of(&points), ends, core: core(&points) }
}

/// A sentence for the reader if not all points are shown.
pub(in crate::scan) fn note(page: &ScanPage<'_>) -> String {
    let n_measured = page.n_points();
    if n_measured <= MAX_POINTS {
        return String::new();
    }
    format!("{} of {} points are shown.", text::count(MAX_POINTS), text::count(n_measured))
}

/// Takes one point from each run of equal length, at a place that looks random: a fixed place would show the
/// camera's pixel grid as stripes.
fn choose(views: &[Vec<Vec3>], n_measured: usize, max_points: usize) -> (Vec<Vec3>, Vec<usize>) {
    let n_shown = n_measured.min(max_points);
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

/// The index of the point taken from run `i`, if `n` points are divided into `n_runs` runs; it increases with
/// `i`.
fn pick(i: usize, n_runs: usize, n: usize) -> usize {
    let (start, end) = (i * n / n_runs, (i + 1) * n / n_runs);
    // Multiplicative hashing with 2^64 over the golden ratio; the upper half of the product is well mixed.
    let hash = (i as u64 + 1)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .rotate_left(32)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15);
    start + (((hash >> 32) * (end - start) as u64) >> 32) as usize
}

pub(super) fn core(points: &[Vec3]) -> [Vec3; 2] {
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
    fn nothing_measured_is_no_fault() {
        let cloud = packed(&[], 10);
        assert_eq!((cloud.points, cloud.ends), (PackedPositions::default(), vec![]));
    }
}
