use super::utility::check_ray_spacing;
use crate::Error;
use crate::checked::checked_when_read;
use serde::{Deserialize, Serialize};

/// Parameters of planners that leave nothing to choose but how densely they cast rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct RayConfig {
    /// Distance between neighbouring planning rays at the far side of the box, in voxels of the finest size,
    /// at least 0.1. Default 2, as for [`MaxFlow`](super::MaxFlow).
    pub ray_spacing: f64,
}

impl Default for RayConfig {
    fn default() -> Self {
        Self { ray_spacing: 2.0 }
    }
}

checked_when_read!(RayConfig);

impl RayConfig {
    /// Fails if the value is out of range.
    pub fn check(&self) -> Result<(), Error> {
        check_ray_spacing(self.ray_spacing)
    }
}
