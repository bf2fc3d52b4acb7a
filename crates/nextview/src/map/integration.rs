use crate::geometry::{Plane, VoxelBlock};
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// The rays of a scan that are traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum RayRule {
    /// A ray to every measured point. The default.
    #[default]
    EveryPoint,
    /// One ray to the centre of every voxel that holds a measured point (OctoMap's `discretize`).
    OnePerEndVoxel,
}

/// The effect on the map of rays that end outside the region of interest, behind or next to the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Background {
    /// They carve free space along their path through the region. The default.
    #[default]
    Carve,
    /// They are ignored, as in the paper's simulation, where only points on the object exist.
    Ignore,
}

/// Settings for integrating a scan into a map.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integration {
    /// The rays to trace.
    pub rays: RayRule,
    /// The effect of rays that end outside the region.
    pub background: Background,
    /// The voxels that may change. Default: all of space.
    pub region: Option<VoxelBlock>,
    /// A surface that is not mapped, such as a table, raised by the tolerance: points that are not above it
    /// end a free ray without a hit. Default: `None`.
    pub ground: Option<Plane>,
}

/// The changes made by a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapUpdate {
    /// Number of voxels updated as hit.
    pub n_hits: usize,
    /// Number of voxels updated as crossed.
    pub n_misses: usize,
    /// Number of voxels measured for the first time.
    pub n_first_measured: usize,
    /// Number of voxels that became occupied.
    pub n_newly_occupied: usize,
}

impl AddAssign for MapUpdate {
    fn add_assign(&mut self, other: Self) {
        self.n_hits += other.n_hits;
        self.n_misses += other.n_misses;
        self.n_first_measured += other.n_first_measured;
        self.n_newly_occupied += other.n_newly_occupied;
    }
}
