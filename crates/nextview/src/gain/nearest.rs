use crate::geometry::VoxelBlock;
use rayon::prelude::*;

/// Stands for "fewer points than K".
pub(super) const NONE: u32 = u32::MAX;

/// The squared distances, in voxels, from every voxel of the block to its K nearest of the given voxels, ascending
/// and padded with [`NONE`].
///
/// Exact and separable, like a distance transform (Felzenszwalb & Huttenlocher 2012): of the points in a row
/// along x, only the K nearest along x can be among the K nearest of any voxel of that row, and so on for y and z. So
/// each axis is one pass that merges the lists of a line, outward from the voxel until nothing can be nearer.
pub(super) fn nearest_squared<const K: usize>(block: &VoxelBlock, points: &[usize]) -> Vec<[u32; K]> {
    let mut lists = vec![[NONE; K]; block.n_voxels()];
    for &point in points {
        lists[point][0] = 0;
    }
    for axis in 0..3 {
        lists = merge_along(block, &lists, axis);
    }
    lists
}

fn merge_along<const K: usize>(block: &VoxelBlock, lists: &[[u32; K]], axis: usize) -> Vec<[u32; K]> {
    let (stride, length) = (block.strides()[axis], block.dims()[axis] as usize);
    let merged = |index: usize| {
        let place = index / stride % length;
        let mut nearest = [NONE; K];
        for distance in 0..length {
            let distance_sq = (distance * distance) as u32;
            if distance_sq >= nearest[K - 1] {
                break;
            }
            if distance <= place {
                merge(&mut nearest, &lists[index - distance * stride], distance_sq);
            }
            if distance > 0 && place + distance < length {
                merge(&mut nearest, &lists[index + distance * stride], distance_sq);
            }
        }
        nearest
    };
    (0..lists.len()).into_par_iter().with_min_len(1024).map(merged).collect()
}

/// Inserts the distances of `other`, moved away by `offset`, into the ascending list.
fn merge<const K: usize>(nearest: &mut [u32; K], other: &[u32; K], offset: u32) {
    for &distance in other.iter().take_while(|&&d| d != NONE) {
        let distance = distance + offset;
        if distance >= nearest[K - 1] {
            return;
        }
        let mut slot = K - 1;
        while slot > 0 && nearest[slot - 1] > distance {
            nearest[slot] = nearest[slot - 1];
            slot -= 1;
        }
        nearest[slot] = distance;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    /// The slow twin: every distance, sorted.
    fn by_sorting<const K: usize>(block: &VoxelBlock, points: &[usize]) -> Vec<[u32; K]> {
        let distances = |index: usize| {
            let to = |&p: &usize| (block.key(index) - block.key(p)).length_squared() as u32;
            let mut all: Vec<u32> = points.iter().map(to).chain([NONE; K]).collect();
            all.sort_unstable();
            std::array::from_fn(|i| all[i])
        };
        (0..block.n_voxels()).map(distances).collect()
    }

    proptest! {
        #[test]
        fn equals_sorting_all_distances(dims in prop::array::uniform3(1_u32..9), picks in prop::collection::vec(any::<prop::sample::Index>(), 0..30)) {
            let block = VoxelBlock::new(IVec3::new(-3, 0, 5), UVec3::from_array(dims)).unwrap();
            let mut points: Vec<usize> = picks.iter().map(|pick| pick.index(block.n_voxels())).collect();
            points.sort_unstable();
            points.dedup();
            prop_assert_eq!(nearest_squared::<6>(&block, &points), by_sorting::<6>(&block, &points));
            prop_assert_eq!(nearest_squared::<1>(&block, &points), by_sorting::<1>(&block, &points));
        }
    }
}
