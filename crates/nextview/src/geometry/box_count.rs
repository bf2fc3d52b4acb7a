use super::{VoxelBlock, VoxelKey};
use glam::{IVec3, Vec3};

/// Counts marked voxels in any cube in constant time: a summed-area table (Crow 1984) in three dimensions.
#[derive(Clone, Debug)]
pub(crate) struct BoxCount {
    block: VoxelBlock,
    /// By voxel corner, x fastest: the number of marked voxels with lower coordinates in x, y and z.
    sums: Vec<u32>,
    /// Whether voxels outside the block count as marked.
    marks_outside: bool,
}

impl BoxCount {
    /// Builds the table for the voxels marked by index, with all or none of those outside the block marked.
    pub fn new(block: VoxelBlock, marks_outside: bool, is_marked: impl Fn(usize) -> bool) -> Self {
        let [row, slice] = corner_strides(&block);
        let mut sums = vec![0; slice * (block.dims().z as usize + 1)];
        for voxel in 0..block.n_voxels() {
            let [x, y, z] = (block.key(voxel) - block.min()).to_array().map(|x| x as usize);
            sums[x + 1 + (y + 1) * row + (z + 1) * slice] = is_marked(voxel) as u32;
        }
        for stride in [1, row, slice] {
            // Layers of zeros at the lower sides end each sum.
            (stride..sums.len()).for_each(|i| {
                if !is_lower_side(i, row, slice) {
                    sums[i] += sums[i - stride]
                }
            });
        }
        Self { block, sums, marks_outside }
    }

    /// Returns the number of marked voxels in the cube that extends `radius` voxels around this voxel.
    pub fn around(&self, center: VoxelKey, radius: i32) -> u32 {
        let (low, high) = (center - radius - self.block.min(), center + radius + 1 - self.block.min());
        let dims = self.block.dims().as_ivec3();
        let (a, b) = (low.clamp(IVec3::ZERO, dims), high.clamp(IVec3::ZERO, dims));
        let inside = self.between(a, b);
        if !self.marks_outside {
            return inside;
        }
        inside + ((high - low).element_product() - (b - a).element_product()) as u32
    }

    /// Returns the change of the count around a voxel along x, y and z, over two voxels each.
    pub fn gradient(&self, center: VoxelKey, radius: i32) -> Vec3 {
        let along = |axis: IVec3| {
            self.around(center + axis, radius) as f32 - self.around(center - axis, radius) as f32
        };
        Vec3::new(along(IVec3::X), along(IVec3::Y), along(IVec3::Z))
    }

    /// Returns the number of marked voxels between two corners, relative to the block's lowest corner.
    fn between(&self, a: IVec3, b: IVec3) -> u32 {
        let [row, slice] = corner_strides(&self.block);
        let sum = |x: i32, y: i32, z: i32| self.sums[x as usize + y as usize * row + z as usize * slice];
        let below =
            |z: i32| (sum(b.x, b.y, z) + sum(a.x, a.y, z)).wrapping_sub(sum(a.x, b.y, z) + sum(b.x, a.y, z));
        below(b.z).wrapping_sub(below(a.z))
    }
}

/// Returns the index strides of a corner along y and z.
fn corner_strides(block: &VoxelBlock) -> [usize; 2] {
    let row = block.dims().x as usize + 1;
    [row, row * (block.dims().y as usize + 1)]
}

fn is_lower_side(corner: usize, row: usize, slice: usize) -> bool {
    corner.is_multiple_of(row) || corner % slice < row || corner < slice
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec3;
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: one voxel after the other.
        #[test]
        fn counts_what_is_there(dims in prop::array::uniform3(1_u32..7), center in prop::array::uniform3(-4_i32..9), radius in 0_i32..5, outside: bool) {
            let block = VoxelBlock::new(IVec3::ONE, UVec3::from_array(dims)).unwrap();
            let is_marked = |index: usize| index * 31 % 7 < 3;
            let counts = BoxCount::new(block, outside, is_marked);
            let center = IVec3::from_array(center);
            let mut expected = 0;
            for z in -radius..=radius {
                for y in -radius..=radius {
                    for x in -radius..=radius {
                        expected += block.index(center + IVec3::new(x, y, z)).map_or(outside, is_marked) as u32;
                    }
                }
            }
            prop_assert_eq!(counts.around(center, radius), expected);
        }
    }
}
