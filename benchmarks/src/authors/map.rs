use super::Outcome;
use super::recording::{Recording, VOXEL_SIZE};
use super::sensor::Image;
use glam::DVec3;
use nextview::geometry::{Lattice, VoxelBlock, VoxelKey};
use nextview::map::{
    Background, Integration, LogOdds, Occupancy, OccupancyMap, SensorModel, Snapshot, entropy,
};
use std::f64::consts::LN_2;

/// Above this probability the authors' program takes a voxel for occupied.
pub const OCCUPIED: f64 = 0.65;

/// Below this probability it takes a voxel for free.
pub const FREE: f64 = 0.45;

/// Their map: OctoMap in voxels of 1 cm.
pub struct Map {
    map: OccupancyMap,
    created: VoxelBlock,
}

impl Map {
    /// A map in which these voxels exist and nothing is measured.
    pub fn new(created: VoxelBlock) -> Outcome<Self> {
        Ok(Self { map: OccupancyMap::new(Lattice::new(VOXEL_SIZE)?, SensorModel::default())?, created })
    }

    /// Enters what a camera at `origin` saw: a voxel with a point is a hit, others on the way to one a miss,
    /// and, unless `hits_only`, those on the way past the object as well.
    pub fn insert(&mut self, image: &Image, origin: DVec3, hits_only: bool) -> Outcome<()> {
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

    /// The log-odds of the voxels that exist; 0 where nothing was measured.
    pub fn log_odds(&self) -> Vec<f32> {
        let keys = (0..self.created.n_voxels()).map(|voxel| self.created.key(voxel));
        keys.map(|key| self.map.log_odds(key).map_or(0.0, |value| value.0)).collect()
    }
}

/// What planning knows of the voxels of the box.
pub struct Knowledge {
    /// The probability that the voxel is occupied; 0.5 where nothing was measured.
    pub probability: Vec<f64>,
    /// Which voxels are unknown, free and occupied.
    pub snapshot: Snapshot,
}

impl Knowledge {
    /// From the log-odds of the voxels that exist. By the authors' bands, 0.45 to 0.65 is unknown; otherwise
    /// only what was never measured.
    pub fn new(log_odds: &[f32], recording: &Recording, by_bands: bool) -> Outcome<Self> {
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

    /// Number of voxels that are occupied for the authors.
    pub fn n_occupied(&self) -> usize {
        self.probability.iter().filter(|&&p| p > OCCUPIED).count()
    }

    /// The entropy of all voxels together, nats.
    pub fn entropy(&self) -> f64 {
        self.probability.iter().map(|&p| entropy(p)).sum()
    }

    /// The same as a share of that of a box of which nothing is known.
    pub fn entropy_share(&self) -> f64 {
        self.entropy() / (self.probability.len() as f64 * LN_2)
    }

    /// By existing voxel, whether planning rays end in it: occupied ones do, and with the slip all of
    /// log-odds 0 or more, as those that were never measured.
    pub fn ray_ends(&self, log_odds: &[f32], stop_at_unknown: bool, recording: &Recording) -> Vec<bool> {
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
