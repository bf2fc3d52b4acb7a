use nextview::map::{Occupancy, Snapshot};
use std::ops::Range;

/// The input of NBV-Net: the occupancy probability in 32 x 32 x 32 cells of a cube.
///
/// The cube has the longest side and, to half a voxel, the centre of the snapshot's box. Each cell takes the
/// highest probability of its measured voxels, like OctoMap's inner nodes. If there are more cells than
/// voxels, several take the same voxel. A cell without measurements, including those outside the box, is 0.5.
///
/// The cells are those of the network of the paper's authors: z varies fastest, then y, then x.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid(Vec<f32>);

impl Grid {
    /// Number of cells along a side.
    pub const SIDE: usize = 32;

    /// Number of cells.
    pub const N_CELLS: usize = Self::SIDE.pow(3);

    /// The largest byte in [`to_bytes`](Self::to_bytes), which stands for probability 1. It is even: unknown
    /// cells have a byte of their own, 127.
    pub const MAX_BYTE: u8 = 254;

    /// Creates the grid of the snapshot's box.
    pub fn new(snapshot: &Snapshot) -> Self {
        let dims = snapshot.block().dims().to_array().map(|n| n as usize);
        let side = dims[0].max(dims[1]).max(dims[2]);
        let [xs, ys, zs] = dims.map(|n| (0..Self::SIDE).map(move |cell| voxels(cell, side, n)));
        let mut cells = Vec::with_capacity(Self::N_CELLS);
        for x in xs {
            for y in ys.clone() {
                cells.extend(zs.clone().map(|z| highest(snapshot, [x.clone(), y.clone(), z])));
            }
        }
        Self(cells)
    }

    /// Creates a grid from one byte per cell, which stands for the probability byte /
    /// [`MAX_BYTE`](Self::MAX_BYTE); `None` if the number of bytes is wrong or one exceeds the maximum.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let is_whole = bytes.len() == Self::N_CELLS && bytes.iter().all(|&byte| byte <= Self::MAX_BYTE);
        is_whole.then(|| Self(bytes.iter().map(|&byte| byte as f32 / Self::MAX_BYTE as f32).collect()))
    }

    /// Returns the nearest grid that bytes can represent.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.0.iter().map(|p| (p * Self::MAX_BYTE as f32).round() as u8).collect()
    }

    /// Returns the probabilities, 0..=1.
    pub fn cells(&self) -> &[f32] {
        &self.0
    }
}

/// The voxels of an axis with `n` voxels that lie in a cell if `side` voxels fill the cube; at least one,
/// possibly outside the box.
fn voxels(cell: usize, side: usize, n: usize) -> Range<usize> {
    let (begin, end) = (cell * side / Grid::SIDE, (cell + 1) * side / Grid::SIDE);
    let beside = (side - n) / 2;
    begin.saturating_sub(beside).min(n)..end.max(begin + 1).saturating_sub(beside).min(n)
}

fn highest(snapshot: &Snapshot, [xs, ys, zs]: [Range<usize>; 3]) -> f32 {
    let [_, row, slice] = snapshot.block().strides();
    let rows = zs.flat_map(|z| ys.clone().map(move |y| z * slice + y * row));
    let voxels = rows.flat_map(|begin| begin + xs.start..begin + xs.end);
    let measured = voxels.filter(|&voxel| snapshot.occupancy()[voxel] != Occupancy::Unknown);
    measured.map(|voxel| snapshot.probability()[voxel]).reduce(f32::max).unwrap_or(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, UVec3};
    use nextview::geometry::random::Random;
    use nextview::geometry::{Lattice, VoxelBlock};
    use nextview::map::LogOdds;
    use proptest::prelude::*;

    fn snapshot(dims: UVec3, seed: u64) -> Snapshot {
        let mut random = Random::new(seed, 0);
        let block = VoxelBlock::new(IVec3::new(-7, 3, 40), dims).unwrap();
        let values =
            [None, Some(LogOdds(-0.4)), Some(LogOdds(-1.2)), Some(LogOdds(0.85)), Some(LogOdds(2.0))];
        let states: Vec<Option<LogOdds>> =
            (0..block.n_voxels()).map(|_| values[random.index(5) * random.index(2)]).collect();
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| states[block.index(key)?])
    }

    /// The cell by its definition: all voxels of the cube, one after the other.
    fn slow_cell(snapshot: &Snapshot, cell: [usize; 3]) -> f32 {
        let dims = snapshot.block().dims();
        let side = dims.max_element() as usize;
        let is_in = |axis: usize, at: usize| {
            let begin = cell[axis] * side / 32;
            at == begin || (begin..(cell[axis] + 1) * side / 32).contains(&at)
        };
        let mut found: Option<f32> = None;
        for voxel in 0..snapshot.block().n_voxels() {
            let at = (snapshot.block().key(voxel) - snapshot.block().min()).as_uvec3();
            let at = at + (UVec3::splat(side as u32) - dims) / 2;
            let is_in = is_in(0, at.x as usize) && is_in(1, at.y as usize) && is_in(2, at.z as usize);
            if is_in && snapshot.occupancy()[voxel] != Occupancy::Unknown {
                found = Some(
                    found.map_or(snapshot.probability()[voxel], |p| p.max(snapshot.probability()[voxel])),
                );
            }
        }
        found.unwrap_or(0.5)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn is_what_the_definition_says(dims in prop::array::uniform3(1_u32..70), seed: u64) {
            let snapshot = snapshot(UVec3::from_array(dims), seed);
            let grid = Grid::new(&snapshot);
            prop_assert_eq!(grid.cells().len(), Grid::N_CELLS);
            let mut random = Random::new(seed, 1);
            for _ in 0..40 {
                let cell = [(); 3].map(|()| random.index(32));
                let found = grid.cells()[(cell[0] * 32 + cell[1]) * 32 + cell[2]];
                prop_assert_eq!(found, slow_cell(&snapshot, cell), "{:?}", cell);
            }
        }
    }

    #[test]
    fn every_voxel_shows_in_a_cell() {
        for dims in [UVec3::splat(1), UVec3::new(26, 13, 5), UVec3::splat(32), UVec3::new(33, 34, 65)] {
            for voxel in [0, dims.element_product() as usize / 3, dims.element_product() as usize - 1] {
                let block = VoxelBlock::new(IVec3::ZERO, dims).unwrap();
                let at = |key| (block.index(key) == Some(voxel)).then_some(LogOdds(2.0));
                let grid = Grid::new(&Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, at));
                assert!(grid.cells().iter().any(|&p| p > 0.8), "{dims}, {voxel}");
            }
        }
    }

    #[test]
    fn bytes_keep_the_unknown() {
        let grid = Grid::new(&snapshot(UVec3::splat(40), 5));
        let bytes = grid.to_bytes();
        let read = Grid::from_bytes(&bytes).unwrap();
        for (p, kept) in grid.cells().iter().zip(read.cells()) {
            assert!((p - kept).abs() <= 0.5 / 254.0 && (*p == 0.5) == (*kept == 0.5));
        }
        assert_eq!(read.to_bytes(), bytes);
        assert_eq!(Grid::from_bytes(&bytes[1..]), None);
        assert_eq!(Grid::from_bytes(&vec![255; Grid::N_CELLS]), None);
    }
}
