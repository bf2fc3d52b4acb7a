use super::FreeSpace;
use super::measured_parts::{MeasuredParts, meets};
use crate::geometry::VoxelBlock;
use crate::map::{Occupancy, Snapshot};
use glam::{DVec3, IVec3};
use std::ops::Range;

/// The share of visibility that each voxel of a block passes on, with a layer of [`OUTSIDE`](Self::OUTSIDE)
/// around it: a ray then needs no other test to find the end of the box. The voxels of both are called cells.
#[derive(Debug)]
pub(super) struct PassGrid {
    /// The voxels through which rays are followed: all that could change the visibility of others.
    pub block: VoxelBlock,
    /// The block, with the layer around it.
    pub padded: VoxelBlock,
    /// By cell, 1 - P(occupied) or 1 where free space is clear; 0 where a ray ends; below
    /// [`OUTSIDE`](Self::OUTSIDE) where only a [part](Self::beside) ends it.
    pub passes: Vec<f32>,
    /// Cells in which only parts end rays: those parts, and the share that passes next to them.
    parts: Vec<(u64, f32)>,
}

impl PassGrid {
    /// The value that marks the layer around the block.
    pub const OUTSIDE: f32 = -1.0;

    /// Creates the grid under eq. (2) with the chosen model of free space.
    pub fn new(snapshot: &Snapshot, free_space: FreeSpace) -> Self {
        let pass = |voxel: usize| match (snapshot.occupancy()[voxel], free_space) {
            (Occupancy::Occupied, _) => 0.0,
            (Occupancy::Free, FreeSpace::Clear) => 1.0,
            _ => 1.0 - snapshot.probability()[voxel],
        };
        let block = match free_space {
            FreeSpace::Fades => snapshot.block(),
            FreeSpace::Clear => {
                without_margin(snapshot.block(), |voxel| snapshot.occupancy()[voxel] == Occupancy::Free)
            }
        };
        Self::with_passes(snapshot, block, pass)
    }

    /// Creates the grid for the shares that each voxel of the snapshot passes on, above 0 and up to 1.
    pub fn of_passes(snapshot: &Snapshot, passes: &[f32]) -> Self {
        let block = without_margin(snapshot.block(), |voxel| passes[voxel] == 1.0);
        Self::with_passes(snapshot, block, |voxel| passes[voxel])
    }

    fn with_passes(snapshot: &Snapshot, block: VoxelBlock, pass: impl Fn(usize) -> f32) -> Self {
        let padded = block.padded();
        let passes = vec![Self::OUTSIDE; padded.n_voxels()];
        let mut grid = Self { block, padded, passes, parts: Vec::new() };
        for (cells, voxels) in grid.rows(snapshot) {
            grid.passes[cells].iter_mut().zip(voxels).for_each(|(cell, voxel)| *cell = pass(voxel));
        }
        grid
    }

    /// Makes rays end at the measured parts of occupied voxels and continue next to them. Measured voxels
    /// that are free in the map stay as they are: noise put points there.
    pub fn behind(mut self, measured: &MeasuredParts, snapshot: &Snapshot) -> Self {
        for (cells, voxels) in self.rows(snapshot) {
            for (cell, voxel) in cells.zip(voxels) {
                if measured.is_measured(voxel) && snapshot.occupancy()[voxel] == Occupancy::Occupied {
                    self.parts.push((measured.of(voxel), self.passes[cell]));
                    self.passes[cell] = Self::OUTSIDE - self.parts.len() as f32;
                }
            }
        }
        self
    }

    /// Returns the share of a ray that a cell with a pass below [`OUTSIDE`](Self::OUTSIDE) passes on,
    /// `origin` and `direction` in voxels: 0 if the ray meets one of its parts.
    #[cold]
    pub fn beside(&self, cell: usize, origin: DVec3, direction: DVec3) -> f32 {
        let (parts, pass) = self.parts[(Self::OUTSIDE - self.passes[cell]) as usize - 1];
        if meets(parts, self.padded.key(cell), origin, direction) { 0.0 } else { pass }
    }

    /// The rows of the block along x, as increasing ranges of cells and of voxels of the snapshot.
    pub fn rows(&self, snapshot: &Snapshot) -> impl Iterator<Item = (Range<usize>, Range<usize>)> + use<> {
        let (block, padded, whole) = (self.block, self.padded, snapshot.block());
        let (low, high) = (block.min(), block.max());
        let starts =
            (low.z..=high.z).flat_map(move |z| (low.y..=high.y).map(move |y| IVec3::new(low.x, y, z)));
        let row = move |start: usize| start..start + block.dims().x as usize;
        starts.filter_map(move |key| Some((row(padded.index(key)?), row(whole.index(key)?))))
    }
}

/// The smallest block with all voxels that are not clear (the whole one if there are none): clear space
/// around it neither weakens a ray nor ends it.
fn without_margin(block: VoxelBlock, is_clear: impl Fn(usize) -> bool) -> VoxelBlock {
    let [width, height, depth] = block.dims().to_array().map(|dim| dim as usize);
    let mut corners: Option<(IVec3, IVec3)> = None;
    for row in 0..height * depth {
        let mut voxels = row * width..(row + 1) * width;
        let first = voxels.find(|&voxel| !is_clear(voxel));
        let last = voxels.rfind(|&voxel| !is_clear(voxel)).or(first);
        for voxel in [first, last].into_iter().flatten() {
            let key = block.key(voxel);
            corners = Some(corners.map_or((key, key), |(low, high)| (low.min(key), high.max(key))));
        }
    }
    let inner = corners.and_then(|(low, high)| VoxelBlock::new(low, (high - low + 1).as_uvec3()));
    inner.unwrap_or(block)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Lattice;
    use glam::UVec3;
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: the corners of all voxels that are not clear, and every cell by its key.
        #[test]
        fn holds_the_passes_of_the_least_block(
            dims in prop::array::uniform3(1_u32..7), min in prop::array::uniform3(-5..5),
            clear_share in prop::sample::select(vec![0.0, 0.5, 0.95, 1.0]),
            drawn in prop::collection::vec((0.0..1.0, (0.001..0.999).prop_map(|pass| pass as f32)), 216),
        ) {
            let block = VoxelBlock::new(IVec3::from_array(min), UVec3::from_array(dims)).unwrap();
            let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
            let passes: Vec<f32> =
                drawn[..block.n_voxels()].iter().map(|&(p, pass)| if p < clear_share { 1.0 } else { pass }).collect();
            let grid = PassGrid::of_passes(&snapshot, &passes);
            let weakening = || (0..passes.len()).filter(|&voxel| passes[voxel] < 1.0).map(|voxel| block.key(voxel));
            let corners = weakening().reduce(IVec3::min).zip(weakening().reduce(IVec3::max));
            prop_assert_eq!((grid.block.min(), grid.block.max()), corners.unwrap_or((block.min(), block.max())));
            for cell in 0..grid.padded.n_voxels() {
                let key = grid.padded.key(cell);
                let voxel = grid.block.index(key).and_then(|_| block.index(key));
                prop_assert_eq!(grid.passes[cell], voxel.map_or(PassGrid::OUTSIDE, |voxel| passes[voxel]));
            }
        }
    }
}
