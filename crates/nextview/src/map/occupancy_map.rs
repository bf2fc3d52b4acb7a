use super::brick::{BrickGrid, CELLS, brick_key, cell, voxel_key};
use super::{LogOdds, SensorModel, Snapshot};
use crate::geometry::{Lattice, VoxelBlock, VoxelKey};
use crate::{Cancel, Cancelled, Error};
use glam::IVec3;

/// A probabilistic occupancy map: a log-odds value for each measured voxel.
///
/// It has the semantics of OctoMap (Hornung et al. 2013) at its finest level, but is stored as a sparse grid
/// of bricks of 8 x 8 x 8 voxels, unbounded up to 32-bit keys. [`integrate`](Self::integrate) adds scans;
/// planners read a dense [`Snapshot`] of a box.
#[derive(Clone, Debug)]
pub struct OccupancyMap {
    lattice: Lattice,
    model: SensorModel,
    pub(super) bricks: BrickGrid<LogOddsBrick>,
}

/// Log-odds of the voxels of a brick; NaN if not measured.
#[derive(Clone, Debug)]
pub(super) struct LogOddsBrick(pub(super) [f32; CELLS]);

impl Default for LogOddsBrick {
    fn default() -> Self {
        Self([f32::NAN; CELLS])
    }
}

impl OccupancyMap {
    /// Returns an empty map with the voxels of the lattice. Fails if the sensor model is out of range.
    pub fn new(lattice: Lattice, model: SensorModel) -> Result<Self, Error> {
        model.check()?;
        Ok(Self { lattice, model, bricks: BrickGrid::default() })
    }

    /// Returns a map of measured voxels; of a key that occurs twice, the last value counts. Fails if the
    /// sensor model is out of range, a value is not finite or a key is beyond [`Lattice::REACH`].
    pub fn from_voxels(
        lattice: Lattice,
        model: SensorModel,
        voxels: impl IntoIterator<Item = (VoxelKey, LogOdds)>,
    ) -> Result<Self, Error> {
        let mut map = Self::new(lattice, model)?;
        for (key, value) in voxels {
            if !value.0.is_finite() {
                return Err(Error::invalid(
                    "log-odds",
                    format!("{} at voxel {key}", value.0),
                    "a finite number",
                ));
            }
            if key.min_element() < -Lattice::REACH || key.max_element() > Lattice::REACH {
                return Err(Error::invalid("voxel key", key, "at most 268435456 voxels from the origin"));
            }
            map.set(key, value);
        }
        Ok(map)
    }

    /// Returns the lattice of the voxels.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Returns the sensor model.
    pub fn model(&self) -> &SensorModel {
        &self.model
    }

    /// Returns the log-odds of a voxel; `None` if it was never measured.
    pub fn log_odds(&self, key: VoxelKey) -> Option<LogOdds> {
        let value = self.bricks.get(brick_key(key))?.0[cell(key)];
        (!value.is_nan()).then_some(LogOdds(value))
    }

    /// Returns all measured voxels, in increasing order of z, then y, then x.
    pub fn voxels(&self) -> Vec<(VoxelKey, LogOdds)> {
        let mut voxels: Vec<(VoxelKey, LogOdds)> = self.measured().collect();
        voxels.sort_unstable_by_key(|(key, _)| (key.z, key.y, key.x));
        voxels
    }

    /// Returns all measured voxels in an order that must not influence any result: it may change.
    pub fn measured(&self) -> impl Iterator<Item = (VoxelKey, LogOdds)> {
        self.bricks.iter().flat_map(|(brick, values)| {
            let measured = values.0.iter().enumerate().filter(|(_, value)| !value.is_nan());
            measured.map(move |(cell, &value)| (voxel_key(brick, cell), LogOdds(value)))
        })
    }

    /// Returns a dense copy of a block.
    pub fn snapshot(&self, block: VoxelBlock) -> Snapshot {
        self.snapshot_unless(block, &Cancel::default()).expect("nobody cancels")
    }

    /// As [`snapshot`](Self::snapshot), unless cancelled.
    pub(crate) fn snapshot_unless(&self, block: VoxelBlock, cancel: &Cancel) -> Result<Snapshot, Cancelled> {
        Snapshot::from_bricks(self.lattice, block, |brick| Some(&self.bricks.get(brick)?.0), cancel)
    }

    /// Returns the map in voxels `factor` times as large (at least 1): each has the highest value of the
    /// measured voxels in it, as OctoMap's inner nodes do, and is unknown without any.
    pub fn coarser(&self, factor: u32) -> Result<Self, Error> {
        if factor == 0 || factor > 1 << 15 {
            return Err(Error::invalid("factor", factor, "a whole number from 1 to 32768"));
        }
        let lattice = Lattice::new(self.lattice.voxel_size() * factor as f64)?;
        let mut coarse = Self::new(lattice, self.model)?;
        for (key, LogOdds(value)) in self.measured() {
            let key = key.div_euclid(IVec3::splat(factor as i32));
            let highest = coarse.log_odds(key).map_or(value, |present| present.0.max(value));
            coarse.set(key, LogOdds(highest));
        }
        Ok(coarse)
    }

    fn set(&mut self, key: VoxelKey, value: LogOdds) {
        let slot = self.bricks.slot(brick_key(key));
        self.bricks.at_mut(slot).0[cell(key)] = value.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec3;
    use proptest::prelude::*;

    /// Drawn in double precision, because the single-precision sampler can fail.
    fn log_odds() -> impl Strategy<Value = f32> {
        (-2.0..3.5).prop_map(|log_odds| log_odds as f32)
    }

    fn key() -> impl Strategy<Value = IVec3> {
        (-20..20, -20..20, -20..20).prop_map(|(x, y, z)| IVec3::new(x, y, z))
    }

    fn map_of(voxels: &[(IVec3, f32)]) -> OccupancyMap {
        let voxels = voxels.iter().map(|&(key, value)| (key, LogOdds(value)));
        OccupancyMap::from_voxels(Lattice::new(0.01).unwrap(), SensorModel::default(), voxels).unwrap()
    }

    proptest! {
        #[test]
        fn coarser_voxels_hold_the_highest_child(voxels in prop::collection::vec((key(), log_odds()), 0..60), factor in 1_u32..6) {
            let map = map_of(&voxels);
            let coarse = map.coarser(factor).unwrap();
            let block = VoxelBlock::new(IVec3::splat(-20), UVec3::splat(40)).unwrap();
            let mut expected = std::collections::BTreeMap::new();
            for i in 0..block.n_voxels() {
                if let Some(value) = map.log_odds(block.key(i)) {
                    let parent = block.key(i).div_euclid(IVec3::splat(factor as i32)).to_array();
                    let highest = expected.entry(parent).or_insert(value.0);
                    *highest = highest.max(value.0);
                }
            }
            let found: Vec<_> = coarse.voxels().into_iter().map(|(k, v)| (k.to_array(), v.0)).collect();
            let mut sorted = found.clone();
            sorted.sort_by_key(|(k, _)| *k);
            prop_assert_eq!(sorted, expected.into_iter().collect::<Vec<_>>());
        }

        #[test]
        fn a_snapshot_tells_what_the_map_tells(
            voxels in prop::collection::vec((key(), log_odds()), 0..60),
            min in prop::array::uniform3(-25..15), dims in prop::array::uniform3(1_u32..20),
        ) {
            let map = map_of(&voxels);
            let block = VoxelBlock::new(IVec3::from_array(min), UVec3::from_array(dims)).unwrap();
            let expected = Snapshot::from_fn(map.lattice(), block, |key| map.log_odds(key));
            let found = map.snapshot(block);
            prop_assert_eq!(found.occupancy(), expected.occupancy());
            prop_assert_eq!(found.probability(), expected.probability());
            for (index, &p) in found.probability().iter().enumerate() {
                let value = map.log_odds(block.key(index));
                prop_assert_eq!(p, value.map_or(0.5, |value| value.probability() as f32));
            }
        }
    }

    #[test]
    fn only_finite_values_within_reach_are_taken() {
        let lattice = Lattice::new(0.01).unwrap();
        let of = |key, value| {
            OccupancyMap::from_voxels(lattice, SensorModel::default(), [(key, LogOdds(value))]).is_ok()
        };
        let far = IVec3::new(0, Lattice::REACH, 0);
        assert!(of(IVec3::ZERO, -0.4) && of(far, 0.8) && of(-far, 0.8));
        assert!(!of(far + 1, 0.8) && !of(-far - 1, 0.8) && !of(IVec3::MIN, 0.8) && !of(IVec3::MAX, 0.8));
        assert!(!of(IVec3::ZERO, f32::NAN) && !of(IVec3::ZERO, f32::INFINITY));
    }

    #[test]
    fn an_empty_map_knows_nothing() {
        let map = map_of(&[]);
        assert_eq!(map.log_odds(IVec3::ZERO), None);
        assert!(map.voxels().is_empty() && map.coarser(2).unwrap().voxels().is_empty());
        assert!(map.coarser(0).is_err());
    }
}
