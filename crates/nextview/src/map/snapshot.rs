use super::brick::{CELLS, voxel_key};
use super::key_box::KeyBox;
use super::{LogOdds, Occupancy, entropy};
use crate::geometry::{Lattice, VoxelBlock, VoxelKey};
use crate::{Cancel, Cancelled};
use glam::{DVec3, IVec3};
use std::f64::consts::LN_2;

/// Voxels processed between two checks for cancellation.
const CHUNK: usize = 1 << 16;

/// A dense, immutable copy of a block of the map: the input of planning.
#[derive(Clone, Debug)]
pub struct Snapshot {
    lattice: Lattice,
    block: VoxelBlock,
    occupancy: Vec<Occupancy>,
    probability: Vec<f32>,
}

impl Snapshot {
    /// Returns a snapshot from the known state of each voxel of the block.
    pub fn from_fn(
        lattice: Lattice,
        block: VoxelBlock,
        log_odds: impl Fn(VoxelKey) -> Option<LogOdds>,
    ) -> Self {
        let mut snapshot = Self::unknown(lattice, block);
        let mut known = KnownValues::default();
        for index in 0..block.n_voxels() {
            if let Some(value) = log_odds(block.key(index)) {
                (snapshot.occupancy[index], snapshot.probability[index]) = known.get(value);
            }
        }
        snapshot
    }

    /// Returns a snapshot of the bricks that overlap the block; NaN means not measured.
    pub(super) fn from_bricks<'a>(
        lattice: Lattice,
        block: VoxelBlock,
        brick: impl Fn(IVec3) -> Option<&'a [f32; CELLS]>,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let mut snapshot = Self::unknown(lattice, block);
        let mut known = KnownValues::default();
        let keys = KeyBox::of(block);
        let bricks = keys.bricks();
        for at in (0..bricks.n_voxels()).map(|i| bricks.key(i)) {
            cancel.check()?;
            let Some(values) = brick(at) else { continue };
            let cells = values.iter().enumerate().filter(|(_, value)| !value.is_nan());
            for (index, value) in cells.filter_map(|(cell, &v)| Some((block.index(voxel_key(at, cell))?, v)))
            {
                (snapshot.occupancy[index], snapshot.probability[index]) = known.get(LogOdds(value));
            }
        }
        Ok(snapshot)
    }

    /// Sets this value in the voxels selected by `is_there`.
    pub(crate) fn with_value(
        mut self,
        value: LogOdds,
        is_there: impl Fn(VoxelKey) -> bool,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let known = KnownValues::default().get(value);
        for index in 0..self.block.n_voxels() {
            if index.is_multiple_of(CHUNK) {
                cancel.check()?;
            }
            if is_there(self.block.key(index)) {
                (self.occupancy[index], self.probability[index]) = known;
            }
        }
        Ok(self)
    }

    fn unknown(lattice: Lattice, block: VoxelBlock) -> Self {
        let n = block.n_voxels();
        Self { lattice, block, occupancy: vec![Occupancy::Unknown; n], probability: vec![0.5; n] }
    }

    /// Returns the lattice of the voxels.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Returns the voxels of the snapshot; their indices apply to all its arrays.
    pub fn block(&self) -> VoxelBlock {
        self.block
    }

    /// Returns the known state of each voxel.
    pub fn occupancy(&self) -> &[Occupancy] {
        &self.occupancy
    }

    /// Returns P(occupied) of each voxel; 0.5 if unknown.
    pub fn probability(&self) -> &[f32] {
        &self.probability
    }

    /// Whether the voxel of this point and all around it were seen to be free: even a surface displaced by a
    /// voxel is not here.
    pub fn is_free_around(&self, point: DVec3) -> bool {
        let is_free = |i: usize| self.occupancy[i] == Occupancy::Free;
        let here = self.block.index(self.lattice.key(point));
        here.is_some_and(|i| is_free(i) && self.block.neighbors(i).all(is_free))
    }

    /// Returns the number of voxels in this state.
    pub fn count(&self, state: Occupancy) -> usize {
        self.occupancy.iter().filter(|&&o| o == state).count()
    }

    /// Returns the total entropy of all voxels of the block, nats: the paper's eq. (8).
    pub fn entropy(&self) -> f64 {
        self.probability.iter().map(|&p| entropy(p as f64)).sum()
    }

    /// As [`entropy`](Self::entropy), unless cancelled.
    pub(crate) fn entropy_unless(&self, cancel: &Cancel) -> Result<f64, Cancelled> {
        let mut sum = 0.0;
        for part in self.probability.chunks(CHUNK) {
            cancel.check()?;
            sum = part.iter().fold(sum, |sum, &p| sum + entropy(p as f64));
        }
        Ok(sum)
    }

    /// As [`entropy_share`](Self::entropy_share), unless cancelled.
    pub(crate) fn entropy_share_unless(&self, cancel: &Cancel) -> Result<f64, Cancelled> {
        Ok(self.share_of_unknown(self.entropy_unless(cancel)?))
    }

    /// Returns the entropy as a share, 0..=1, of that of an unknown block: the paper's eqs. (8) and (9).
    pub fn entropy_share(&self) -> f64 {
        self.share_of_unknown(self.entropy())
    }

    /// Returns an entropy, nats, as a share of that of an unknown block.
    pub(crate) fn share_of_unknown(&self, entropy: f64) -> f64 {
        entropy / (self.block.n_voxels() as f64 * LN_2)
    }
}

/// Converts log-odds, with a cache of recent results: a map has few distinct values, and an exponential costs
/// more than everything else in a snapshot.
struct KnownValues([Option<(f32, (Occupancy, f32))>; 256]);

impl Default for KnownValues {
    fn default() -> Self {
        Self([None; 256])
    }
}

impl KnownValues {
    fn get(&mut self, LogOdds(value): LogOdds) -> (Occupancy, f32) {
        // Fibonacci hashing of the bits.
        let place = &mut self.0[(value.to_bits().wrapping_mul(0x9E37_79B9) >> 24) as usize];
        match *place {
            Some((known, meaning)) if known == value => meaning,
            _ => place.insert((value, meaning(value))).1,
        }
    }
}

fn meaning(value: f32) -> (Occupancy, f32) {
    match value {
        v if v > 0.0 => (Occupancy::Occupied, LogOdds(v).probability() as f32),
        v if v < 0.0 => (Occupancy::Free, LogOdds(v).probability() as f32),
        _ => (Occupancy::Unknown, 0.5),
    }
}
