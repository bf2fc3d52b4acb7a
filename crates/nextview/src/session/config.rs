use super::{MultiResolution, ObjectBox, Table, Views};
use crate::Error;
use crate::geometry::{Aabb, Lattice, VoxelBlock};
use crate::map::{Background, RayRule, SensorModel};
use crate::motion::MotionConfig;
use crate::registration::RegistrationConfig;
use serde::{Deserialize, Serialize};

/// Bytes per voxel of the box that a session and its planner hold at their peak: map, snapshot, nearest frontier
/// voxels, weights, flow.
const BYTES_PER_VOXEL: u64 = 200;

/// What a [`Session`](super::Session) needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SessionConfig {
    /// Edge of a voxel, metres, at least 0.0001; the finest, where planning begins in coarser ones.
    pub voxel_size: f64,
    /// Whether planning begins in coarser voxels. Default: no.
    pub multi_resolution: Option<MultiResolution>,
    /// The box in which the object lies. Only voxels with their centre inside are mapped and planned for.
    pub object_box: ObjectBox,
    /// What the object stands on. Default: nothing.
    pub table: Table,
    /// Number of the view to begin with, where views are fixed. Default 0.
    pub first_view: usize,
    /// How measurements change voxels. Default OctoMap's.
    pub sensor_model: SensorModel,
    /// Which rays of a scan are traced. Default: every point.
    pub rays: RayRule,
    /// What rays past the object do. Default: they carve free space.
    pub background: Background,
    /// Whether frames are aligned to what was measured before, and how. Default: no, poses are right as given.
    pub registration: Option<RegistrationConfig>,
    /// How the camera moves. Default: see there.
    pub motion: MotionConfig,
    /// When to stop.
    pub stop: StopConfig,
    /// Most memory the box may need, MB. Default 4096.
    pub memory_limit_mb: u64,
}

/// When a scan is over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StopConfig {
    /// Most views to take, at least 1. Default 10.
    pub max_views: usize,
    /// Stop when the entropy in the box is below this share, 0..=1, of that of an unknown box: q_thresh of the
    /// paper's eq. (9), where it is 0.5. Default: do not, since the share says how empty the box is rather than
    /// how completely the object was seen.
    pub entropy_share: Option<f64>,
    /// Stop when this share, 0..=1, of the surface that can be seen is
    /// [estimated](crate::planner::Outlook::completeness) to have been seen. Default: do not. Planners that expect
    /// nothing never stop so.
    pub completeness: Option<f64>,
    /// Stop when the next view is expected to add less than this share, 0..=1, to what was seen so far. Default: do
    /// not. Planners that expect nothing never stop so.
    pub expected_gain: Option<f64>,
    /// Stop rather than let the straight path through all views become longer than this, metres, positive. Default: do
    /// not.
    pub path_length: Option<f64>,
}

impl Default for StopConfig {
    fn default() -> Self {
        Self {
            max_views: 10,
            entropy_share: None,
            completeness: None,
            expected_gain: None,
            path_length: None,
        }
    }
}

impl StopConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        if self.max_views == 0 {
            return Err(Error::invalid("max_views", 0, "at least 1"));
        }
        let shares = [
            ("entropy_share", self.entropy_share),
            ("completeness", self.completeness),
            ("expected_gain", self.expected_gain),
        ];
        for (name, share) in shares.into_iter().filter_map(|(name, share)| Some((name, share?))) {
            if !(0.0..=1.0).contains(&share) {
                return Err(Error::invalid(name, share, "a number in 0..=1"));
            }
        }
        match self.path_length {
            Some(length) if length.is_nan() || length <= 0.0 => {
                Err(Error::invalid("path_length", length, "a positive number of metres"))
            }
            _ => Ok(()),
        }
    }
}

impl SessionConfig {
    /// The defaults, for voxels of this size (metres) and an object in this box.
    pub fn new(voxel_size: f64, bounds: Aabb) -> Self {
        Self {
            voxel_size,
            multi_resolution: None,
            object_box: ObjectBox::Known(bounds),
            table: Table::None,
            first_view: 0,
            sensor_model: SensorModel::default(),
            rays: RayRule::default(),
            background: Background::default(),
            registration: None,
            motion: MotionConfig::default(),
            stop: StopConfig::default(),
            memory_limit_mb: 4096,
        }
    }

    /// Fails on the first value out of range, or a first view that there is not.
    pub fn check(&self, views: &Views) -> Result<(), Error> {
        if matches!(views, Views::Fixed(views) if self.first_view >= views.len()) {
            return Err(Error::invalid(
                "first_view",
                self.first_view,
                "a number below that of view candidates",
            ));
        }
        self.stop.check()?;
        self.motion.check()?;
        views.check()?;
        Lattice::new(self.voxel_size)?;
        self.multi_resolution.map_or(Ok(()), |rule| rule.check(self.voxel_size))?;
        self.sensor_model.check()?;
        self.table.check()?;
        self.registration.map_or(Ok(()), |registration| registration.check())?;
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
