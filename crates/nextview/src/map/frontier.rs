use super::{Occupancy, Snapshot};

/// The frontier of a snapshot: the unknown voxels that touch, by a face, an edge or a corner, at least one free and
/// at least one occupied voxel of it (the paper, section III.A). Indices in increasing order.
pub fn frontier(snapshot: &Snapshot) -> Vec<usize> {
    let block = snapshot.block();
    // Frontier voxels all touch the few occupied ones: start from those.
    let mut touched = vec![false; block.n_voxels()];
    for index in (0..block.n_voxels()).filter(|&i| snapshot.occupancy()[i] == Occupancy::Occupied) {
        block.neighbors(index).for_each(|neighbor| touched[neighbor] = true);
    }
    let is_frontier = |&index: &usize| {
        touched[index]
            && snapshot.occupancy()[index] == Occupancy::Unknown
            && block.neighbors(index).any(|neighbor| snapshot.occupancy()[neighbor] == Occupancy::Free)
    };
    (0..block.n_voxels()).filter(is_frontier).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::LogOdds;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equals_the_definition(states in prop::collection::vec(0_u8..3, 60)) {
            let block = VoxelBlock::new(IVec3::new(-1, 2, 0), UVec3::new(3, 4, 5)).unwrap();
            let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| {
                match states[block.index(key).unwrap()] {
                    0 => None,
                    1 => Some(LogOdds(-0.4)),
                    _ => Some(LogOdds(0.8)),
                }
            });
            let touches = |i: usize, state| {
                (0..60).any(|j| {
                    j != i && (block.key(i) - block.key(j)).abs().max_element() == 1 && states[j] == state
                })
            };
            let expected: Vec<usize> =
                (0..60).filter(|&i| states[i] == 0 && touches(i, 1) && touches(i, 2)).collect();
            prop_assert_eq!(frontier(&snapshot), expected);
        }
    }
}
