use crate::geometry::{Plane, VoxelBlock};
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Which rays of a scan are traced.
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

/// The effect on the map of rays that end outside the region of interest, behind or beside the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Background {
    /// They carve free space on their way through the region. The default.
    #[default]
    Carve,
    /// They are left out, as in the paper's simulation, where only points on the object exist.
    Ignore,
}

/// How a scan is written into a map.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integration {
    /// Which rays are traced.
    pub rays: RayRule,
    /// The effect of rays that end outside the region.
    pub background: Background,
    /// The voxels that may change; all of space by default.
    pub region: Option<VoxelBlock>,
    /// A surface that is not mapped, such as a table, raised by the tolerance: points that are not above it
    /// end a free ray and do not hit. None by default.
    pub ground: Option<Plane>,
}

/// The changes made by a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapUpdate {
    /// Voxels that were updated as hit.
    pub n_hits: usize,
    /// Voxels that were updated as crossed.
    pub n_misses: usize,
    /// Voxels measured for the first time.
    pub n_first_measured: usize,
    /// Voxels that became occupied.
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
