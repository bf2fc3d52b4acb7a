use super::recording::{RecordedRun, VOXEL_SIZE};
use super::sensor::CameraImage;
use crate::Outcome;
use glam::DVec3;
use nextview::geometry::{Lattice, VoxelBlock, VoxelKey};
use nextview::map::{
    Background, Integration, LogOdds, Occupancy, OccupancyMap, SensorModel, Snapshot, entropy,
};
use std::f64::consts::LN_2;

/// Probability above which the authors' program treats a voxel as occupied.
pub const OCCUPIED: f64 = 0.65;

/// Probability below which it treats a voxel as free.
pub const FREE: f64 = 0.45;

/// The authors' map: OctoMap in voxels of 1 cm.
pub struct Map {
    map: OccupancyMap,
    created: VoxelBlock,
}

impl Map {
    /// Creates a map in which these voxels exist without measurements.
    pub fn new(created: VoxelBlock) -> Outcome<Self> {
        Ok(Self { map: OccupancyMap::new(Lattice::new(VOXEL_SIZE)?, SensorModel::default())?, created })
    }

    /// Inserts an image of a camera at `origin`: a voxel with a point is a hit, other voxels on the way to a
    /// point are misses, and, unless `hits_only`, so are those on the way past the object.
    pub fn insert(&mut self, image: &CameraImage, origin: DVec3, hits_only: bool) -> Outcome<()> {
        if hits_only {
            let whole = Integration { background: Background::Ignore, ..Integration::default() };
            self.map.integrate_points(&image.points, origin, &whole)?;
        } else {
            let region = Integration { region: Some(self.created), ..Integration::default() };
            let all: Vec<DVec3> = image.points.iter().chain(&image.background).copied().collect();
            self.map.integrate_points(&all, origin, &region)?;
        }
        Ok(())
    }

    /// Returns the log-odds of the existing voxels; 0 without measurements.
    pub fn log_odds(&self) -> Vec<f32> {
        let keys = (0..self.created.n_voxels()).map(|voxel| self.created.key(voxel));
        keys.map(|key| self.map.log_odds(key).map_or(0.0, |value| value.0)).collect()
    }
}

/// The planner's knowledge of the voxels of the box.
pub struct Knowledge {
    /// The probability that the voxel is occupied; 0.5 without measurements.
    pub probability: Vec<f64>,
    /// The unknown, free and occupied voxels.
    pub snapshot: Snapshot,
}

impl Knowledge {
    /// Creates it from the log-odds of the existing voxels. With the authors' bands, 0.45 to 0.65 is unknown;
    /// otherwise only what was never measured.
    pub fn new(log_odds: &[f32], recording: &RecordedRun, by_bands: bool) -> Outcome<Self> {
        let value = |key: VoxelKey| recording.created.index(key).map_or(0.0, |voxel| log_odds[voxel]);
        let known = |key: VoxelKey| {
            let value = LogOdds(value(key));
            let is_known = match by_bands {
                true => !(FREE..=OCCUPIED).contains(&value.probability()),
                false => value.0 != 0.0,
            };
            is_known.then_some(value)
        };
        let block = recording.block;
        let keys = (0..block.n_voxels()).map(|voxel| block.key(voxel));
        let probability = keys.map(|key| LogOdds(value(key)).probability()).collect();
        Ok(Self { probability, snapshot: Snapshot::from_fn(Lattice::new(VOXEL_SIZE)?, block, known) })
    }

    /// Returns the number of voxels that the authors treat as occupied.
    pub fn n_occupied(&self) -> usize {
        self.probability.iter().filter(|&&p| p > OCCUPIED).count()
    }

    /// Returns the total entropy of all voxels, nats.
    pub fn entropy(&self) -> f64 {
        self.probability.iter().map(|&p| entropy(p)).sum()
    }

    /// Returns the entropy as a share of that of an unknown box.
    pub fn entropy_share(&self) -> f64 {
        self.entropy() / (self.probability.len() as f64 * LN_2)
    }

    /// Returns for every existing voxel whether planning rays end in it: occupied voxels and, with the slip,
    /// all voxels with log-odds of 0 or more, including those never measured.
    pub fn ray_ends(&self, log_odds: &[f32], stop_at_unknown: bool, recording: &RecordedRun) -> Vec<bool> {
        let created = recording.created;
        let is_occupied = |voxel: usize| {
            let in_box = recording.block.index(created.key(voxel));
            in_box.is_some_and(|voxel| self.snapshot.occupancy()[voxel] == Occupancy::Occupied)
        };
        (0..created.n_voxels())
            .map(|voxel| if stop_at_unknown { log_odds[voxel] >= 0.0 } else { is_occupied(voxel) })
            .collect()
    }
}
