use crate::Error;
use crate::geometry::{Aabb, Lattice, VoxelBlock};
use crate::map::{Background, RayRule, SensorModel};
use crate::view::ViewSpace;
use serde::{Deserialize, Serialize};

/// Bytes per voxel of the box that a session and its planner hold at their peak: map, snapshot, nearest frontier voxels,
/// weights, flow.
const BYTES_PER_VOXEL: u64 = 200;

/// What a [`Session`](super::Session) needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SessionConfig {
    /// Edge of a voxel, metres, at least 0.0001.
    pub voxel_size: f64,
    /// The box in which the object lies, metres. Only voxels with their centre inside are mapped and planned for.
    pub bounds: Aabb,
    /// Number of the view to begin with. Default 0.
    pub first_view: usize,
    /// How measurements change voxels. Default OctoMap's.
    pub sensor_model: SensorModel,
    /// Which rays of a scan are traced. Default: every point.
    pub rays: RayRule,
    /// What rays past the object do. Default: they carve free space.
    pub background: Background,
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
}

impl Default for StopConfig {
    fn default() -> Self {
        Self { max_views: 10, entropy_share: None }
    }
}

impl SessionConfig {
    /// The defaults, for voxels of this size (metres) and an object in this box.
    pub fn new(voxel_size: f64, bounds: Aabb) -> Self {
        Self {
            voxel_size,
            bounds,
            first_view: 0,
            sensor_model: SensorModel::default(),
            rays: RayRule::default(),
            background: Background::default(),
            stop: StopConfig::default(),
            memory_limit_mb: 4096,
        }
    }

    /// The voxels of the box, if the whole configuration is in range and fits these views.
    pub fn block(&self, views: &ViewSpace) -> Result<VoxelBlock, Error> {
        if self.first_view >= views.len() {
            return Err(Error::invalid(
                "first_view",
                self.first_view,
                "a number below that of view candidates",
            ));
        }
        if self.stop.max_views == 0 {
            return Err(Error::invalid("max_views", 0, "at least 1"));
        }
        if self.stop.entropy_share.is_some_and(|share| !(0.0..=1.0).contains(&share)) {
            let share = self.stop.entropy_share.unwrap_or_default();
            return Err(Error::invalid("entropy_share", share, "a number in 0..=1"));
        }
        if !(self.bounds.min.is_finite() && self.bounds.max.is_finite()) {
            return Err(Error::invalid("bounds", format!("{:?}", self.bounds), "a finite box"));
        }
        self.check_memory()?;
        let block = Lattice::new(self.voxel_size)?.block_inside(&self.bounds);
        block.ok_or_else(|| {
            Error::invalid("bounds", format!("{:?}", self.bounds), "a box that holds at least one voxel")
        })
    }

    fn check_memory(&self) -> Result<(), Error> {
        let n_voxels = (self.bounds.size() / self.voxel_size).ceil().max(glam::DVec3::ONE).element_product();
        let needed_mb = (n_voxels * BYTES_PER_VOXEL as f64 / 1e6) as u64;
        if needed_mb <= self.memory_limit_mb {
            return Ok(());
        }
        let what =
            format!("a box of {:.3} m with voxels of {} m", self.bounds.longest_side(), self.voxel_size);
        Err(Error::TooLarge { what, needed_mb, limit_mb: self.memory_limit_mb })
    }
}
