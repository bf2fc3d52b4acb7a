//! Exposure differences between photos.

use super::photo::Photo;
use super::sight::{PhotoSight, ViewedMesh};
use nextview::{Cancel, Cancelled};

/// Colours outside this range may be clipped and carry no information on the exposure.
const USABLE: std::ops::RangeInclusive<f32> = 8.0..=247.0;

/// Pixels around a vertex in which colours must be similar, and the share by which they may differ: at a
/// colour edge, a small pose error looks like an exposure difference.
const AROUND: f64 = 2.0;
const ALIKE: f32 = 0.15;

/// Minimum number of shared vertices for comparing two photos, and the maximum number used.
const SHARED: std::ops::RangeInclusive<usize> = 20..=10_000;

/// Weight of the prior that gains are 1, as a number of shared vertices.
const PRIOR: f64 = 1.0;

/// Returns the factors for red, green and blue of each photo that equalise vertices in all photos that see
/// them: least squares of the logarithms, using for each pair of photos the median difference, which no
/// minority of vertices can move far. The geometric mean of the factors is 1.
pub(super) fn gains(
    photos: &[Photo],
    sights: &[PhotoSight],
    shape: &ViewedMesh,
    cancel: &Cancel,
) -> Result<Vec<[f32; 3]>, Cancelled> {
    let n = photos.len();
    let seen = logarithms(photos, sights, shape, cancel)?;
    let mut differences: Vec<[Vec<f64>; 3]> = vec![Default::default(); n * n];
    for list in &seen {
        for (k, (i, one)) in list.iter().enumerate() {
            for (j, other) in &list[..k] {
                let of_pair = &mut differences[i * n + j];
                for (channel, values) in
                    of_pair.iter_mut().enumerate().filter(|(_, v)| v.len() < *SHARED.end())
                {
                    values.push(other[channel] - one[channel]);
                }
            }
        }
    }
    let mut matrix = vec![vec![0.0; n]; n];
    let mut right = vec![[0.0; 3]; n];
    (0..n).for_each(|i| matrix[i][i] = PRIOR);
    for (pair, mut values) in differences.into_iter().enumerate() {
        let (i, j, weight) = (pair / n, pair % n, values[0].len());
        if !SHARED.contains(&weight) {
            continue;
        }
        cancel.check()?;
        let weight = weight as f64;
        matrix[i][i] += weight;
        matrix[j][j] += weight;
        matrix[i][j] -= weight;
        matrix[j][i] -= weight;
        for (channel, values) in values.iter_mut().enumerate() {
            let middle = values.len() / 2;
            let median = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
            right[i][channel] += weight * median;
            right[j][channel] -= weight * median;
        }
    }
    Ok(solve(matrix, right).into_iter().map(|gain| gain.map(|log| log.exp() as f32)).collect())
}

/// Logarithms of red, green and blue.
type Logarithms = [f64; 3];

/// Returns, by vertex, the photos that see it with similar colours around it, and the logarithms of its
/// colour there.
fn logarithms(
    photos: &[Photo],
    sights: &[PhotoSight],
    shape: &ViewedMesh,
    cancel: &Cancel,
) -> Result<Vec<Vec<(usize, Logarithms)>>, Cancelled> {
    let mut seen = vec![Vec::new(); shape.vertices.len()];
    for (i, (photo, sight)) in photos.iter().zip(sights).enumerate() {
        cancel.check()?;
        let mut is_seen = vec![false; seen.len()];
        let good = shape.triangles.iter().zip(&sight.quality).filter(|(_, quality)| **quality > 0.0);
        good.for_each(|(triangle, _)| triangle.iter().for_each(|vertex| is_seen[*vertex as usize] = true));
        for (vertex, place) in sight.places.iter().enumerate().filter(|(vertex, _)| is_seen[*vertex]) {
            let color = place.and_then(|place| even_color(photo, place.pixel.x, place.pixel.y));
            seen[vertex].extend(color.map(|color| (i, color.map(|value| f64::from(value).ln()))));
        }
    }
    Ok(seen)
}

/// Returns the colour at an image position if it is neither clipped nor next to another colour.
fn even_color(photo: &Photo, u: f64, v: f64) -> Option<[f32; 3]> {
    let color = photo.sample(u, v);
    let around = [[AROUND, 0.0], [-AROUND, 0.0], [0.0, AROUND], [0.0, -AROUND]];
    let is_alike = |[x, y]: [f64; 2]| {
        let other = photo.sample(u + x, v + y);
        (0..3).all(|k| (other[k] - color[k]).abs() <= ALIKE * color[k])
    };
    let is_usable = color.iter().all(|value| USABLE.contains(value));
    (is_usable && around.into_iter().all(is_alike)).then_some(color)
}

/// Solves with a symmetric positive definite matrix, by elimination.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let n = right.len();
    for k in 0..n {
        let (above, below) = matrix.split_at_mut(k + 1);
        let (pivot, of_pivot) = (&above[k], right[k]);
        for (row, of_row) in below.iter_mut().zip(&mut right[k + 1..]) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(value, other)| *value -= factor * other);
            of_row.iter_mut().zip(of_pivot).for_each(|(value, other)| *value -= factor * other);
        }
    }
    for k in (0..n).rev() {
        let known = |channel: usize| (k + 1..n).map(|j| matrix[k][j] * right[j][channel]).sum::<f64>();
        right[k] = [0, 1, 2].map(|channel| (right[k][channel] - known(channel)) / matrix[k][k]);
    }
    right
}
