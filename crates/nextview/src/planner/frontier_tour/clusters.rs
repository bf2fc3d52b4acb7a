use crate::geometry::VoxelBlock;

/// Minimum number of voxels of a cluster.
const LEAST_VOXELS: usize = 4;

/// Returns the voxels that belong to a cluster of at least four, or all if there is no such cluster. Both
/// lists are in increasing order. Voxels that touch by a face, an edge or a corner are one cluster.
pub(super) fn without_small_clusters(voxels: &[usize], block: &VoxelBlock) -> Vec<usize> {
    let large = clusters(voxels, block).into_iter().filter(|cluster| cluster.len() >= LEAST_VOXELS);
    let mut left: Vec<usize> = large.flatten().collect();
    left.sort_unstable();
    if left.is_empty() { voxels.to_vec() } else { left }
}

fn clusters(voxels: &[usize], block: &VoxelBlock) -> Vec<Vec<usize>> {
    let mut is_found = vec![false; voxels.len()];
    let mut clusters = Vec::new();
    for first in 0..voxels.len() {
        let mut cluster = Vec::new();
        let mut open = vec![first];
        while let Some(place) = open.pop() {
            if !std::mem::replace(&mut is_found[place], true) {
                cluster.push(voxels[place]);
                let around = block.neighbors(voxels[place]);
                open.extend(around.filter_map(|neighbor| voxels.binary_search(&neighbor).ok()));
            }
        }
        clusters.push(cluster);
    }
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: two voxels are one cluster if the transitive closure of touching joins them.
        #[test]
        fn clusters_are_joined_by_touching(drawn in prop::collection::vec(0_u8..10, 120), n_there in 0_u8..10) {
            let block = VoxelBlock::new(IVec3::new(-2, 3, 0), UVec3::new(4, 5, 6)).unwrap();
            let voxels: Vec<usize> = (0..120).filter(|&i| drawn[i] < n_there).collect();
            let n = voxels.len();
            let touch = |a: usize, b: usize| (block.key(a) - block.key(b)).abs().max_element() <= 1;
            let mut joined: Vec<Vec<bool>> =
                voxels.iter().map(|&a| voxels.iter().map(|&b| touch(a, b)).collect()).collect();
            for via in 0..n {
                for a in 0..n {
                    for b in 0..n {
                        joined[a][b] |= joined[a][via] && joined[via][b];
                    }
                }
            }
            let is_large = |a: &usize| joined[*a].iter().filter(|&&is| is).count() >= 4;
            let large: Vec<usize> = (0..n).filter(is_large).map(|a| voxels[a]).collect();
            let expected = if large.is_empty() { voxels.clone() } else { large };
            prop_assert_eq!(without_small_clusters(&voxels, &block), expected);
        }
    }
}
