//! Differences of exposure between photos.

use super::photo::Photo;
use super::sight::Sight;
use crate::{Cancel, Cancelled};

/// Colours outside this range may be cut off and say nothing of the exposure.
const USABLE: std::ops::RangeInclusive<f32> = 8.0..=247.0;

/// How firmly gains stay at 1, in vertices that two photos share.
const PRIOR: f64 = 1.0;

/// The factors for red, green and blue of each photo that make vertices look alike in all photos that see
/// them: least squares of the differences of the logarithms. Their geometric mean is 1.
pub(super) fn gains(
    photos: &[Photo],
    sights: &[Sight],
    triangles: &[[u32; 3]],
    n_vertices: usize,
    cancel: &Cancel,
) -> Result<Vec<[f32; 3]>, Cancelled> {
    let n = photos.len();
    let mut seen = vec![Vec::new(); n_vertices];
    for (photo, sight) in sights.iter().enumerate() {
        cancel.check()?;
        let mut is_seen = vec![false; n_vertices];
        let good = triangles.iter().zip(&sight.quality).filter(|(_, quality)| **quality > 0.0);
        good.for_each(|(triangle, _)| triangle.iter().for_each(|i| is_seen[*i as usize] = true));
        for (vertex, place) in sight.places.iter().enumerate().filter(|(vertex, _)| is_seen[*vertex]) {
            let Some(place) = place else { continue };
            let color = photos[photo].sample(place.pixel.x, place.pixel.y);
            if color.iter().all(|value| USABLE.contains(value)) {
                seen[vertex].push((photo, color.map(|value| f64::from(value).ln())));
            }
        }
    }
    let mut matrix = vec![vec![0.0; n]; n];
    let mut right = vec![[0.0; 3]; n];
    (0..n).for_each(|i| matrix[i][i] = PRIOR);
    for list in &seen {
        for (k, (i, one)) in list.iter().enumerate() {
            for (j, other) in &list[..k] {
                matrix[*i][*i] += 1.0;
                matrix[*j][*j] += 1.0;
                matrix[*i][*j] -= 1.0;
                matrix[*j][*i] -= 1.0;
                for channel in 0..3 {
                    right[*i][channel] += other[channel] - one[channel];
                    right[*j][channel] += one[channel] - other[channel];
                }
            }
        }
    }
    Ok(solve(matrix, right).into_iter().map(|gain| gain.map(|log| log.exp() as f32)).collect())
}

/// Solves for a matrix that is symmetric and positive definite, by elimination.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let n = right.len();
    for k in 0..n {
        for i in k + 1..n {
            let factor = matrix[i][k] / matrix[k][k];
            for j in k..n {
                matrix[i][j] -= factor * matrix[k][j];
            }
            for channel in 0..3 {
                right[i][channel] -= factor * right[k][channel];
            }
        }
    }
    for k in (0..n).rev() {
        for channel in 0..3 {
            let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j][channel]).sum();
            right[k][channel] = (right[k][channel] - known) / matrix[k][k];
        }
    }
    right
}
