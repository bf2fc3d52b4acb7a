//! Differences of exposure between photos.

use super::photo::Photo;
use super::sight::{Shape, Sight};
use crate::{Cancel, Cancelled};

/// Colours outside this range may be cut off and say nothing of the exposure.
const USABLE: std::ops::RangeInclusive<f32> = 8.0..=247.0;

/// Pixels around a vertex in which colours must be alike, and the share by which they may differ: at an edge
/// of colours, a small error of a pose looks like a difference of exposure.
const AROUND: f64 = 2.0;
const ALIKE: f32 = 0.15;

/// Fewest vertices that two photos must share to be compared, and the most that are.
const SHARED: std::ops::RangeInclusive<usize> = 20..=10_000;

/// How firmly gains stay at 1, in vertices that two photos share.
const PRIOR: f64 = 1.0;

/// The factors for red, green and blue of each photo that make vertices look alike in all photos that see
/// them: least squares of the logarithms, by pair of photos the median of the differences, which no minority
/// of vertices can move far. The geometric mean of the factors is 1.
pub(super) fn gains(
    photos: &[Photo],
    sights: &[Sight],
    shape: &Shape,
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

/// Of red, green and blue.
type Logarithms = [f64; 3];

/// By vertex, the photos that see it where colours are alike around it, and the logarithms of its colour
/// there.
fn logarithms(
    photos: &[Photo],
    sights: &[Sight],
    shape: &Shape,
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

/// The colour at a place if it is neither cut off nor beside another colour.
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

/// Solves for a matrix that is symmetric and positive definite, by elimination.
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
