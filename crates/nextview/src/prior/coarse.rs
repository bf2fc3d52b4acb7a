use crate::geometry::{VoxelBlock, VoxelKey};
use crate::map::{LogOdds, Occupancy, Snapshot};
use crate::{Cancel, Cancelled};
use std::borrow::Cow;

/// Voxels processed between two checks for cancellation.
const CHUNK: usize = 1 << 16;

/// Longest side of a block, in voxels, for which the prior was trained.
const LONGEST: u32 = 72;

/// Returns the snapshot if its block is no larger than those in training, otherwise a copy in voxels large
/// enough for that.
///
/// As in a map of larger voxels, a voxel is occupied if a part of it is, else free if a part of it is, else
/// unknown. This resolution is enough to show the object's shape, and the planning time does not grow with
/// the resolution of the map.
///
/// Fails if `cancel` is set.
pub fn coarse_enough<'a>(snapshot: &'a Snapshot, cancel: &Cancel) -> Result<Cow<'a, Snapshot>, Cancelled> {
    let mut coarse = Cow::Borrowed(snapshot);
    while coarse.block().dims().max_element() > LONGEST {
        coarse = Cow::Owned(halved(&coarse, cancel)?);
    }
    Ok(coarse)
}

/// The block in voxels twice as large.
fn halved(snapshot: &Snapshot, cancel: &Cancel) -> Result<Snapshot, Cancelled> {
    let fine = snapshot.block();
    let lattice = snapshot.lattice().doubled();
    let (low, high): (VoxelKey, VoxelKey) = (fine.min() >> 1, fine.max() >> 1);
    let block = VoxelBlock::new(low, (high - low + 1).as_uvec3()).expect("not smaller than a voxel");
    let mut known = vec![None; block.n_voxels()];
    for (voxel, &state) in snapshot.occupancy().iter().enumerate() {
        if voxel.is_multiple_of(CHUNK) {
            cancel.check()?;
        }
        let Some(coarse) = block.index(fine.key(voxel) >> 1).filter(|_| state != Occupancy::Unknown) else {
            continue;
        };
        let probability = snapshot.probability()[voxel];
        let most = known[coarse].get_or_insert(probability);
        *most = probability.max(*most);
    }
    Ok(Snapshot::from_fn(lattice, block, |key| {
        let probability = known[block.index(key)?]?;
        Some(LogOdds((probability / (1.0 - probability)).ln()))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Lattice;
    use crate::geometry::random::Random;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    fn snapshot(min: IVec3, dims: UVec3, seed: u64) -> Snapshot {
        let mut random = Random::new(seed, 0);
        let block = VoxelBlock::new(min, dims).unwrap();
        let (unknown, occupied) = (random.unit(), random.unit());
        let mut state = || match (random.unit() < unknown, random.unit() < occupied) {
            (true, _) => None,
            (_, true) => Some(0.85 * (1 + random.index(4)) as f32),
            _ => Some(-0.4 * (1 + random.index(5)) as f32),
        };
        let states: Vec<Option<f32>> = (0..block.n_voxels()).map(|_| state()).collect();
        Snapshot::from_fn(Lattice::new(0.003).unwrap(), block, |key| states[block.index(key)?].map(LogOdds))
    }

    /// State and probability of a voxel that is `size` voxels of the snapshot wide, by definition.
    fn slow_state(fine: &Snapshot, coarse: VoxelKey, size: i32) -> (Occupancy, f32) {
        let part = |i: i32| coarse * size + IVec3::new(i % size, i / size % size, i / (size * size));
        let parts: Vec<usize> = (0..size.pow(3)).filter_map(|i| fine.block().index(part(i))).collect();
        assert!(!parts.is_empty(), "a coarse voxel has a part in the block");
        for state in [Occupancy::Occupied, Occupancy::Free] {
            let alike = parts.iter().filter(|&&voxel| fine.occupancy()[voxel] == state);
            if let Some(most) = alike.map(|&voxel| fine.probability()[voxel]).reduce(f32::max) {
                return (state, most);
            }
        }
        (Occupancy::Unknown, 0.5)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Voxels of two and of four times the size, with keys of either sign.
        #[test]
        fn is_what_the_definition_says(
            min in prop::array::uniform3(-90..20), length in prop_oneof![73_u32..145, 145_u32..200],
            across in prop::array::uniform2(1_u32..6), axis in 0_usize..3, seed: u64,
        ) {
            let mut dims = [length, across[0], across[1]];
            dims.rotate_right(axis);
            let fine = snapshot(IVec3::from_array(min), UVec3::from_array(dims), seed);
            let coarse = coarse_enough(&fine, &Cancel::default()).unwrap();
            let size = (coarse.lattice().voxel_size() / 0.003).round() as i32;
            prop_assert!(coarse.block().dims().max_element() <= LONGEST);
            prop_assert!(size == 2 || 2 * coarse.block().dims().max_element() + 2 > LONGEST, "no coarser than needed");
            let (block, whole) = (fine.block(), coarse.block());
            // Each voxel lies in one coarse voxel, and no coarse voxel lies outside the block.
            prop_assert_eq!(whole.min(), block.min().div_euclid(IVec3::splat(size)));
            prop_assert_eq!(whole.max(), block.max().div_euclid(IVec3::splat(size)));
            for voxel in 0..whole.n_voxels() {
                let (state, probability) = slow_state(&fine, whole.key(voxel), size);
                prop_assert_eq!(coarse.occupancy()[voxel], state);
                prop_assert!((coarse.probability()[voxel] - probability).abs() < 1e-6);
            }
            for voxel in 0..block.n_voxels() {
                let center = fine.lattice().center(block.key(voxel));
                prop_assert!(whole.index(coarse.lattice().key(center)).is_some());
            }
        }
    }

    #[test]
    fn what_is_coarse_enough_is_left_alone() {
        for dims in [UVec3::ONE, UVec3::new(72, 3, 72)] {
            let fine = snapshot(IVec3::splat(-5), dims, 4);
            assert!(
                matches!(coarse_enough(&fine, &Cancel::default()), Ok(Cow::Borrowed(same)) if std::ptr::eq(same, &fine))
            );
        }
        let long = snapshot(IVec3::splat(-5), UVec3::new(1, 73, 1), 4);
        assert!(matches!(coarse_enough(&long, &Cancel::default()), Ok(Cow::Owned(_))));
    }
}
