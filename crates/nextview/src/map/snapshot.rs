use super::{LogOdds, Occupancy, entropy};
use crate::geometry::{Lattice, VoxelBlock, VoxelKey};
use std::f64::consts::LN_2;

/// A dense, immutable copy of a block of the map: what planning reads.
#[derive(Clone, Debug)]
pub struct Snapshot {
    lattice: Lattice,
    block: VoxelBlock,
    occupancy: Vec<Occupancy>,
    probability: Vec<f32>,
}

impl Snapshot {
    /// A snapshot from what is known of each voxel of the block.
    pub fn from_fn(
        lattice: Lattice,
        block: VoxelBlock,
        log_odds: impl Fn(VoxelKey) -> Option<LogOdds>,
    ) -> Self {
        let (occupancy, probability) = (0..block.n_voxels())
            .map(|index| match log_odds(block.key(index)) {
                Some(value) if value.0 > 0.0 => (Occupancy::Occupied, value.probability() as f32),
                Some(value) if value.0 < 0.0 => (Occupancy::Free, value.probability() as f32),
                _ => (Occupancy::Unknown, 0.5),
            })
            .unzip();
        Self { lattice, block, occupancy, probability }
    }

    /// The lattice of the voxels.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The voxels of the snapshot; their indices number all its arrays.
    pub fn block(&self) -> VoxelBlock {
        self.block
    }

    /// What is known of each voxel.
    pub fn occupancy(&self) -> &[Occupancy] {
        &self.occupancy
    }

    /// P(occupied) of each voxel; 0.5 where unknown.
    pub fn probability(&self) -> &[f32] {
        &self.probability
    }

    /// Number of voxels in this state.
    pub fn count(&self, state: Occupancy) -> usize {
        self.occupancy.iter().filter(|&&o| o == state).count()
    }

    /// The paper's eq. (8): the entropy of all voxels of the block together, nats.
    pub fn entropy(&self) -> f64 {
        self.probability.iter().map(|&p| entropy(p as f64)).sum()
    }

    /// The paper's eqs. (8) and (9): entropy as a share, 0..=1, of that of a block nothing is known of.
    pub fn entropy_share(&self) -> f64 {
        self.entropy() / (self.block.n_voxels() as f64 * LN_2)
    }
}
