use super::{MultiResolutionConfig, ObjectBox, StopConfig, Table, Views};
use crate::Error;
use crate::checked::checked_when_read;
use crate::geometry::{Aabb, Lattice, VoxelBlock};
use crate::map::{Background, RayRule, SensorModel};
use crate::motion::MotionConfig;
use crate::registration::RegistrationConfig;
use serde::{Deserialize, Serialize};

/// Bytes per voxel of the box that a session and its planner hold at their peak: map, snapshot, nearest
/// frontier voxels, weights, flow.
const BYTES_PER_VOXEL: u64 = 200;

/// Configuration of a [`Session`](super::Session).
///
/// In files, voxel size and object box are required.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct SessionConfig {
    /// Edge of a voxel, metres, at least 0.0001; the finest, where planning begins in coarser ones.
    #[serde(rename = "voxel_size_m")]
    pub voxel_size: f64,
    /// Maximum number of views, at least 1. Default 10.
    #[serde(default = "default_max_views")]
    pub max_views: usize,
    /// Number of the view to begin with, where views are fixed. Default 0.
    #[serde(default)]
    pub first_view: usize,
    /// Maximum memory for the box, MB. Default 4096.
    #[serde(default = "default_memory_limit_mb")]
    pub memory_limit_mb: u64,
    /// The box in which the object lies. Only voxels with their centre inside are mapped and planned for.
    pub object_box: ObjectBox,
    /// The surface that the object stands on. Default: none.
    #[serde(default)]
    pub table: Table,
    /// Which rays of a scan are traced. Default: every point.
    #[serde(default)]
    pub rays: RayRule,
    /// The effect of rays past the object. Default: they carve free space.
    #[serde(default)]
    pub background: Background,
    /// How measurements change voxels. Default OctoMap's.
    #[serde(default)]
    pub sensor_model: SensorModel,
    /// Whether planning begins in coarser voxels. Default: no.
    #[serde(default)]
    pub multi_resolution: MultiResolutionConfig,
    /// Whether frames are aligned to the surface measured before, and how. Default: no; poses are used as
    /// given.
    #[serde(default)]
    pub registration: RegistrationConfig,
    /// How the camera moves. Default: see there.
    #[serde(default)]
    pub motion: MotionConfig,
    /// When to stop before all views are taken. Default: only when no view gains anything.
    #[serde(default)]
    pub stop: StopConfig,
}

checked_when_read!(SessionConfig);

fn default_max_views() -> usize {
    10
}

fn default_memory_limit_mb() -> u64 {
    4096
}

impl SessionConfig {
    /// The defaults, for voxels of this size (metres) and an object in this box.
    pub fn new(voxel_size: f64, bounds: Aabb) -> Self {
        Self {
            voxel_size,
            max_views: default_max_views(),
            first_view: 0,
            memory_limit_mb: default_memory_limit_mb(),
            object_box: ObjectBox::Known(bounds),
            table: Table::None,
            rays: RayRule::default(),
            background: Background::default(),
            sensor_model: SensorModel::default(),
            multi_resolution: MultiResolutionConfig::default(),
            registration: RegistrationConfig::default(),
            motion: MotionConfig::default(),
            stop: StopConfig::default(),
        }
    }

    /// Fails on the first value out of range, or a first view that does not exist.
    pub fn check_with(&self, views: &Views) -> Result<(), Error> {
        if matches!(views, Views::Fixed(views) if self.first_view >= views.len()) {
            return Err(Error::invalid(
                "first_view",
                self.first_view,
                "a number below that of view candidates",
            ));
        }
        views.check()?;
        self.check()
    }

    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        if self.max_views == 0 {
            return Err(Error::invalid("max_views", 0, "at least 1"));
        }
        self.stop.check()?;
        self.motion.check()?;
        Lattice::new(self.voxel_size)?;
        self.multi_resolution.check_for(self.voxel_size)?;
        self.sensor_model.check()?;
        self.table.check()?;
        self.registration.check()?;
        match self.object_box {
            ObjectBox::Known(bounds) => self.block(&bounds).map(|_| ()),
            ObjectBox::Growing => Ok(()),
        }
    }

    /// The finest voxels of a box, if they are within the memory limit.
    pub fn block(&self, bounds: &Aabb) -> Result<VoxelBlock, Error> {
        if !(bounds.min.is_finite() && bounds.max.is_finite()) {
            return Err(Error::invalid("bounds", format!("{bounds:?}"), "a finite box"));
        }
        self.check_memory(bounds)?;
        let block = Lattice::new(self.voxel_size)?.block_inside(bounds);
        block.ok_or_else(|| {
            Error::invalid("bounds", format!("{bounds:?}"), "a box that holds at least one voxel")
        })
    }

    fn check_memory(&self, bounds: &Aabb) -> Result<(), Error> {
        let n_voxels = (bounds.size() / self.voxel_size).ceil().max(glam::DVec3::ONE).element_product();
        let needed_mb = (n_voxels * BYTES_PER_VOXEL as f64 / 1e6) as u64;
        if needed_mb <= self.memory_limit_mb {
            return Ok(());
        }
        let what = format!("a box of {:.3} m with voxels of {} m", bounds.longest_side(), self.voxel_size);
        Err(Error::TooLarge { what, needed_mb, limit_mb: self.memory_limit_mb })
    }
}
