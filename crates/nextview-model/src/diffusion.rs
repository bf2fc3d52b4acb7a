//! Fills in unknown voxels of a block from those around them.

use nextview::geometry::VoxelBlock;
use nextview::{Cancel, Cancelled};
use rayon::prelude::*;

/// Number of times each value is replaced by the mean around it, on every level.
const SWEEPS: usize = 48;

/// Gives every voxel without a value one: in the limit of many sweeps the harmonic function, where each of
/// these voxels has the mean of its neighbours (the steady state of the volumetric diffusion of Davis et al.
/// 2002). Nothing flows through the border of the block.
///
/// The sweeps begin with the values of voxels twice as large, found in the same way: voxels far from all
/// known values would otherwise take too many sweeps. Without any known value, all are zero.
pub(super) fn diffuse(
    block: &VoxelBlock,
    known: &[Option<f32>],
    cancel: &Cancel,
) -> Result<Vec<f32>, Cancelled> {
    let open: Vec<usize> = (0..known.len()).filter(|&i| known[i].is_none()).collect();
    let mut values: Vec<f32> = known.iter().map(|value| value.unwrap_or(0.0)).collect();
    if open.is_empty() || open.len() == known.len() {
        return Ok(values);
    }
    let halved = Halved::new(block);
    let coarse = diffuse(&halved.coarse, &halved.means(known), cancel)?;
    open.iter().for_each(|&i| values[i] = coarse[halved.parent(i)]);
    for _ in 0..SWEEPS {
        cancel.check()?;
        sweep(block, &open, &mut values);
    }
    Ok(values)
}

/// Replaces each of these values by its mean with its neighbours, all at once: the result does not depend on
/// threads.
fn sweep(block: &VoxelBlock, open: &[usize], values: &mut [f32]) {
    let means: Vec<f32> = open.par_iter().map(|&i| mean_around(block, values, i)).collect();
    open.iter().zip(means).for_each(|(&i, mean)| values[i] = mean);
}

/// Returns the mean of a voxel's value and those of its up to six face neighbours. Without its own,
/// neighbours could swap values forever.
fn mean_around(block: &VoxelBlock, values: &[f32], index: usize) -> f32 {
    let (mut sum, mut n) = (values[index], 1.0);
    for (stride, length) in block.strides().into_iter().zip(block.dims().to_array()) {
        let along = index / stride % length as usize;
        if along > 0 {
            sum += values[index - stride];
            n += 1.0;
        }
        if along + 1 < length as usize {
            sum += values[index + stride];
            n += 1.0;
        }
    }
    sum / n
}

/// A block and its counterpart in voxels twice as large.
struct Halved {
    fine: VoxelBlock,
    coarse: VoxelBlock,
}

impl Halved {
    fn new(fine: &VoxelBlock) -> Self {
        let dims = (fine.dims() + 1) / 2;
        let coarse = VoxelBlock::new(fine.min(), dims).expect("it is smaller");
        Self { fine: *fine, coarse }
    }

    /// Returns the coarse voxel that contains a fine one.
    fn parent(&self, index: usize) -> usize {
        let local = (self.fine.key(index) - self.fine.min()) / 2;
        self.coarse.index(self.coarse.min() + local).expect("it covers the fine block")
    }

    /// Returns the mean of the known values in each coarse voxel.
    fn means(&self, known: &[Option<f32>]) -> Vec<Option<f32>> {
        let mut sums = vec![(0.0, 0_u8); self.coarse.n_voxels()];
        for (i, value) in known.iter().enumerate() {
            let Some(value) = value else { continue };
            let (sum, n) = &mut sums[self.parent(i)];
            *sum += value;
            *n += 1;
        }
        sums.into_iter().map(|(sum, n)| (n > 0).then(|| sum / n as f32)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, UVec3};
    use nextview::geometry::random::Random;

    fn block(dims: [u32; 3]) -> VoxelBlock {
        VoxelBlock::new(IVec3::new(-2, 0, 5), UVec3::from_array(dims)).unwrap()
    }

    /// The slow twin: one level, until nothing changes.
    fn relaxed(block: &VoxelBlock, known: &[Option<f32>]) -> Vec<f32> {
        let mut values: Vec<f32> = known.iter().map(|value| value.unwrap_or(0.0)).collect();
        for _ in 0..2000 {
            for i in (0..known.len()).filter(|&i| known[i].is_none()) {
                let beside = |j: &usize| (block.key(*j) - block.key(i)).abs().element_sum() == 1;
                let around: Vec<f32> = (0..known.len()).filter(beside).map(|j| values[j]).collect();
                values[i] = around.iter().sum::<f32>() / around.len() as f32;
            }
        }
        values
    }

    /// A few sweeps leave an error below a tenth of the largest value, 1.
    #[test]
    fn open_values_are_means_of_those_around_them() {
        let mut random = Random::new(5, 0);
        for (dims, share) in [([5, 4, 6], 0.1), ([1, 9, 1], 0.3), ([6, 6, 6], 0.1), ([3, 3, 3], 0.9)] {
            let block = block(dims);
            let mut known: Vec<Option<f32>> = (0..block.n_voxels())
                .map(|_| (random.unit() < share).then(|| 2.0 * random.unit() as f32 - 1.0))
                .collect();
            known[0] = Some(1.0);
            let expected = relaxed(&block, &known);
            let found = diffuse(&block, &known, &Cancel::default()).unwrap();
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert!((found - expected).abs() < 0.1, "{dims:?}, voxel {i}: {found} {expected}");
                assert!(known[i].is_none_or(|known| known == *found));
            }
        }
    }

    #[test]
    fn nothing_known_is_zero_and_all_known_stays() {
        let block = block([3, 2, 2]);
        assert_eq!(diffuse(&block, &[None; 12], &Cancel::default()).unwrap(), [0.0; 12]);
        let all: Vec<Option<f32>> = (0..12).map(|i| Some(i as f32)).collect();
        let found = diffuse(&block, &all, &Cancel::default()).unwrap();
        assert_eq!(found.into_iter().map(Some).collect::<Vec<_>>(), all);
    }

    /// A wall known only at one end of a long block continues to the other.
    #[test]
    fn a_value_reaches_far_through_the_unknown() {
        let block = block([200, 4, 4]);
        let known: Vec<Option<f32>> = (0..block.n_voxels()).map(|i| (i % 200 == 0).then_some(-1.0)).collect();
        let found = diffuse(&block, &known, &Cancel::default()).unwrap();
        assert!(found.iter().all(|value| (value + 1.0).abs() < 1e-5));
    }
}
