use super::{MultiResolutionConfig, StopConfig, Views};
use crate::Error;
use crate::checked::{check_range, checked_when_read};
use crate::geometry::{Aabb, Lattice, Pose, VoxelBlock};
use crate::map::{Background, RayRule, SensorModel};
use crate::motion::MotionConfig;
use crate::object::{ObjectBox, Table};
use crate::registration::RegistrationConfig;
use crate::sensor::{DepthRange, SurfaceNoise};
use crate::surface::LooksGoal;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Peak memory of a session and its planner, bytes per voxel of the box: map, snapshot, nearest frontier
/// voxels, weights, flow.
const BYTES_PER_VOXEL: u64 = 200;

/// Largest voxel size, metres; the coarse voxels of early planning are up to 32768 times as large.
const LARGEST_VOXEL: f64 = 1e6;

/// Maximum number of voxels along a side of the box: such a map, centred, fits the 16-bit keys of an OctoMap.
const MOST_VOXELS: f64 = 32_768.0;

/// Configuration of a [`Session`](super::Session).
///
/// In files, voxel size and object box are required.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct SessionConfig {
    /// Edge of a voxel, metres, at least 0.0001; of the finest one if planning begins in coarser voxels.
    #[serde(rename = "voxel_size_m")]
    pub voxel_size: f64,
    /// Maximum number of views, at least 1. Default 10.
    #[serde(default = "default_max_views")]
    pub max_views: usize,
    /// Number of the first view, if views are fixed. Default 0.
    #[serde(default)]
    pub first_view: usize,
    /// Maximum memory for the box, MB. Default 4096.
    #[serde(default = "default_memory_limit_mb")]
    pub memory_limit_mb: u64,
    /// The box that contains the object. Only voxels whose centre is inside are mapped and planned for.
    pub object_box: ObjectBox,
    /// Largest gap, metres, 0..=1000, between the measured points of parts of one object. Default 0: parts
    /// must touch. It only has an effect if the box grows.
    #[serde(default, rename = "max_gap_m")]
    pub max_gap: f64,
    /// The surface that the object stands on. Default: none.
    #[serde(default)]
    pub table: Table,
    /// The rays to trace in each frame. Default: every point.
    #[serde(default)]
    pub rays: RayRule,
    /// The effect of rays past the object. Default: they carve free space.
    #[serde(default)]
    pub background: Background,
    /// The depths that the camera measures. Planning relies on no others, and candidates that
    /// [follow](Views::Following) the object keep such distances from it. Default: all.
    #[serde(default)]
    pub depth_range: DepthRange,
    /// How measurements change voxels. Default: OctoMap's model.
    #[serde(default)]
    pub sensor_model: SensorModel,
    /// Whether planning begins in coarser voxels. Default: no.
    #[serde(default)]
    pub multi_resolution: MultiResolutionConfig,
    /// Whether and how frames are aligned to the surface measured before. Default: poses are used as given.
    #[serde(default)]
    pub registration: RegistrationConfig,
    /// The random error of the camera. Default: none.
    #[serde(default)]
    pub surface_error: SurfaceNoise,
    /// The random error assumed by planning. If it is large compared to the voxels, surface is looked at
    /// again from elsewhere. Default: none; without a goal, there are no second looks.
    #[serde(default)]
    pub planned_error: SurfaceNoise,
    /// Required accuracy of the surface in each voxel: its expected error along the normal, standard
    /// deviation, metres, positive. Planning then also spends views on surface that was not seen well enough,
    /// and the scan continues while they help. Default: no second looks.
    #[serde(default, rename = "goal_m", skip_serializing_if = "Option::is_none")]
    pub goal: Option<f64>,
    /// Required number of looks at each part of the surface. Planning then also spends views on surface that
    /// was not seen often enough, and the scan continues while they help. Default: no second looks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks: Option<LooksGoal>,
    /// How the camera moves. Default: see its fields.
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

fn is_within_reach(corner: DVec3, voxel_size: f64) -> bool {
    let reach = (Lattice::REACH as f64 * voxel_size).min(Pose::REACH);
    corner.abs().cmple(DVec3::splat(reach)).all()
}

impl SessionConfig {
    /// Returns the defaults for this voxel size (metres) and an object in this box.
    pub fn new(voxel_size: f64, bounds: Aabb) -> Self {
        Self {
            voxel_size,
            max_views: default_max_views(),
            first_view: 0,
            memory_limit_mb: default_memory_limit_mb(),
            object_box: ObjectBox::Known(bounds),
            max_gap: 0.0,
            table: Table::None,
            rays: RayRule::default(),
            background: Background::default(),
            depth_range: DepthRange::default(),
            sensor_model: SensorModel::default(),
            multi_resolution: MultiResolutionConfig::default(),
            registration: RegistrationConfig::default(),
            surface_error: SurfaceNoise::default(),
            planned_error: SurfaceNoise::default(),
            goal: None,
            looks: None,
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
        check_range("voxel_size_m", self.voxel_size, 0.0..=LARGEST_VOXEL, "at most 1e6")?;
        check_range("max_gap_m", self.max_gap, 0.0..=1000.0, "0 to 1000")?;
        self.multi_resolution.check_for(self.voxel_size)?;
        self.depth_range.check()?;
        self.sensor_model.check()?;
        self.table.check()?;
        self.registration.check()?;
        self.surface_error.check()?;
        self.planned_error.check()?;
        self.looks.map_or(Ok(()), |looks| looks.check())?;
        let positive = f64::MIN_POSITIVE..=f64::MAX;
        self.goal.map_or(Ok(()), |goal| check_range("goal_m", goal, positive, "a positive number"))?;
        match self.object_box {
            ObjectBox::Known(bounds) => self.block(&bounds).map(|_| ()),
            ObjectBox::Growing => Ok(()),
        }
    }

    /// Returns the finest voxels of a box; fails if they exceed the memory limit.
    pub fn block(&self, bounds: &Aabb) -> Result<VoxelBlock, Error> {
        if !(bounds.min.is_finite() && bounds.max.is_finite()) {
            return Err(Error::invalid("bounds", format!("{bounds:?}"), "a finite box"));
        }
        self.check_size(bounds)?;
        let block = Lattice::new(self.voxel_size)?.block_inside(bounds);
        block.ok_or_else(|| {
            Error::invalid("bounds", format!("{bounds:?}"), "a box that holds at least one voxel")
        })
    }

    /// Fails if a box has too many voxels or is too far from the origin.
    pub(super) fn check_size(&self, bounds: &Aabb) -> Result<(), Error> {
        let along = (bounds.size() / self.voxel_size).ceil().max(DVec3::ONE);
        let (n_voxels, size) = (along.element_product(), self.voxel_size);
        let needed_mb = (n_voxels * BYTES_PER_VOXEL as f64 / 1e6) as u64;
        if needed_mb > self.memory_limit_mb {
            let what =
                format!("a box of {:.3} m with {n_voxels:.0} voxels of {size} m", bounds.longest_side());
            return Err(Error::TooLarge { what, needed_mb, limit_mb: self.memory_limit_mb });
        }
        let limits =
            "at most 32,768 voxels along a side, 536,870,912 in all, and 268,435,456 from the origin";
        let is_near = [bounds.min, bounds.max].iter().all(|corner| is_within_reach(*corner, size));
        let is_small = along.max_element() <= MOST_VOXELS && n_voxels <= VoxelBlock::MOST_VOXELS as f64;
        if is_near && is_small {
            return Ok(());
        }
        let value = format!("{} to {} m in voxels of {size} m", bounds.min, bounds.max);
        Err(Error::invalid("bounds", value, limits))
    }
}
