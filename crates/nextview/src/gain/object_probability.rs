use super::nearest::{NONE, nearest_squared};
use crate::map::{Occupancy, Snapshot};

/// The paper's alpha times the voxel size: alpha = 0.1 / resolution.
const ALPHA: f64 = 0.1;

/// P(obj) of the paper's eq. (2): the probability that an unknown voxel belongs to the object's surface, from the
/// distances d to its K = 6 nearest frontier voxels, product of exp(-(alpha d)^2). Zero for measured voxels.
///
/// With fewer than six frontier voxels the product runs over those there are. Without any, either nothing of the
/// object has been seen, then every unknown voxel may belong to it (1), or its measured surface is closed and
/// none does (0).
pub fn object_probability(snapshot: &Snapshot, frontier: &[usize]) -> Vec<f64> {
    from_nearest::<6>(snapshot, frontier)
}

/// The same from the K nearest frontier voxels; the paper's K is 6 (section III.A), APORA's 1.
pub(super) fn from_nearest<const K: usize>(snapshot: &Snapshot, frontier: &[usize]) -> Vec<f64> {
    let without_frontier = if snapshot.count(Occupancy::Occupied) == 0 { 1.0 } else { 0.0 };
    let probability = |distances_sq: [u32; K]| {
        if distances_sq[0] == NONE {
            return without_frontier;
        }
        let sum: u64 = distances_sq.iter().filter(|&&d| d != NONE).map(|&d| d as u64).sum();
        (-ALPHA * ALPHA * sum as f64).exp()
    };
    let nearest = nearest_squared::<K>(&snapshot.block(), frontier);
    let unknown = snapshot.occupancy().iter().map(|&o| o == Occupancy::Unknown);
    nearest.into_iter().zip(unknown).map(|(d, unknown)| if unknown { probability(d) } else { 0.0 }).collect()
}
