use super::nearest::{FAR_SQ, sums_of_nearest};
use crate::map::{Occupancy, Snapshot};
use crate::{Cancel, Cancelled};
use rayon::prelude::*;

/// The paper's alpha times the voxel size: alpha = 0.1 / resolution.
const ALPHA: f64 = 0.1;

/// P(obj) of the paper's eq. (2): the probability that an unknown voxel belongs to the object's surface, from
/// the distances d to its K = 6 nearest frontier voxels, product of exp(-(alpha d)^2). Zero for measured
/// voxels.
///
/// With fewer than six frontier voxels, the product is over those available. Without any, the result is 1 if
/// no part of the object has been seen, since every unknown voxel may belong to it, and otherwise 0, since
/// its measured surface is closed.
///
/// Fails if `cancel` is set.
pub fn object_probability(
    snapshot: &Snapshot,
    frontier: &[usize],
    cancel: &Cancel,
) -> Result<Vec<f64>, Cancelled> {
    from_nearest::<6>(snapshot, frontier, cancel)
}

/// Returns P(obj) from the K nearest frontier voxels; the paper's K is 6 (section III.A), APORA's 1.
pub(super) fn from_nearest<const K: usize>(
    snapshot: &Snapshot,
    frontier: &[usize],
    cancel: &Cancel,
) -> Result<Vec<f64>, Cancelled> {
    let is_unknown = |index: usize| snapshot.occupancy()[index] == Occupancy::Unknown;
    let n_voxels = snapshot.block().n_voxels();
    if frontier.is_empty() {
        let unknown = if snapshot.count(Occupancy::Occupied) == 0 { 1.0 } else { 0.0 };
        return Ok((0..n_voxels).map(|index| if is_unknown(index) { unknown } else { 0.0 }).collect());
    }
    let mut points = frontier.to_vec();
    points.sort_unstable();
    points.dedup();
    let sums = sums_of_nearest::<K>(&snapshot.block(), &points, is_unknown, cancel)?;
    // Missing voxels count in the sums as far ones.
    let missing = K.saturating_sub(points.len()) as u32 * FAR_SQ;
    let largest = sums.iter().max().map_or(0, |&sum| sum.saturating_sub(missing).min(FAR_SQ));
    // Sums are few, and each exponential takes as long as ten reads.
    let by_sum: Vec<f64> = (0..=largest).map(|sum| (-ALPHA * ALPHA * sum as f64).exp()).collect();
    let probability = |index: usize| match is_unknown(index) {
        true => by_sum[(sums[index] - missing).min(FAR_SQ) as usize],
        false => 0.0,
    };
    Ok((0..n_voxels).into_par_iter().with_min_len(16_384).map(probability).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_of_a_probability_where_distances_are_no_longer_told_apart() {
        assert_eq!((-ALPHA * ALPHA * FAR_SQ as f64).exp(), 0.0);
    }
}
