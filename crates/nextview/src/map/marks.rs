use super::brick::{BRICK_EDGE, CELLS};
use super::key_box::KeyBox;
use super::scan::VoxelScan;
use crate::geometry::{SegmentFan, VoxelBlock, VoxelKey};
use glam::DVec3;
use rayon::prelude::*;
use std::array::from_fn;
use std::sync::atomic::AtomicU8;

/// The marks that a scan leaves in a voxel.
pub(super) const MISS: u8 = 1;
pub(super) const HIT: u8 = 2;

/// The marks of a scan in a small box of voxels.
///
/// One byte per voxel makes marking a single store, independent of neighbours: all threads write to the same
/// cells, and nothing needs merging.
#[derive(Default)]
pub(super) struct Marks {
    /// All voxels of the bricks of the current box, and one unused cell; 0 between two scans.
    cells: Vec<AtomicU8>,
}

impl Marks {
    /// Marks the voxels that a scan hits and crosses in a box, reports them brick by brick, and clears the
    /// marks.
    #[inline(always)]
    pub fn visit(
        &mut self,
        origin: DVec3,
        scan: &VoxelScan,
        keys: KeyBox,
        mut visit: impl FnMut(VoxelKey, &[u8; CELLS]),
    ) {
        let bricks = keys.bricks();
        let voxels = VoxelBlock::new(bricks.min() * BRICK_EDGE, bricks.dims() * BRICK_EDGE as u32)
            .expect("a block of bricks is not empty");
        self.cells.resize_with(voxels.n_voxels() + 1, Default::default);
        let fan = SegmentFan { from: origin, min: keys.min, max: keys.max, cells: voxels };
        // Chunks large enough to justify a thread.
        scan.ends.par_chunks(1024).for_each(|ends| fan.mark_crossed(ends, &self.cells));
        for index in scan.hits.iter().filter_map(|hit| voxels.index(*hit)) {
            *self.cells[index].get_mut() = HIT;
        }
        for brick in (0..bricks.n_voxels()).map(|index| bricks.key(index)) {
            if let Some(marks) = self.brick(&voxels, brick * BRICK_EDGE) {
                visit(brick, &marks);
            }
        }
        self.cells.clear();
    }

    /// Returns the marks of the brick with lowest voxel `first`; `None` if there are no marks.
    #[inline(always)]
    fn brick(&mut self, voxels: &VoxelBlock, first: VoxelKey) -> Option<[u8; CELLS]> {
        const EDGE: usize = BRICK_EDGE as usize;
        let start = voxels.index(first).expect("the block holds all its bricks");
        let [_, row, slice] = voxels.strides();
        let mut marks = [0; CELLS];
        let mut all = [0; EDGE];
        for (i, target) in marks.chunks_exact_mut(EDGE).enumerate() {
            let start = start + i % EDGE * row + i / EDGE * slice;
            let cells = &mut self.cells[start..start + EDGE];
            let cells: [u8; EDGE] = from_fn(|i| *cells[i].get_mut());
            all = from_fn(|i| all[i] | cells[i]);
            target.copy_from_slice(&cells);
        }
        (all != [0; EDGE]).then_some(marks)
    }
}
