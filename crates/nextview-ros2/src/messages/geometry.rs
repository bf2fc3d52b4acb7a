use super::basic::Header;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// `geometry_msgs/msg/Vector3`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `geometry_msgs/msg/Point`, which has the same fields.
pub type Point = Vector3;

/// `geometry_msgs/msg/Quaternion`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/msg/Pose`, and `geometry_msgs/msg/Transform` with the same fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    pub position: Point,
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/PoseStamped`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    pub header: Header,
    pub pose: Pose,
}

impl From<DVec3> for Vector3 {
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self { x, y, z }
    }
}

impl From<&nextview::geometry::Pose> for Pose {
    fn from(pose: &nextview::geometry::Pose) -> Self {
        let [x, y, z, w] = pose.rotation().to_array();
        Self { position: pose.translation().into(), orientation: Quaternion { x, y, z, w } }
    }
}

impl TryFrom<&Pose> for nextview::geometry::Pose {
    type Error = nextview::Error;

    /// Fails if the orientation is not a rotation.
    fn try_from(pose: &Pose) -> Result<Self, nextview::Error> {
        let Quaternion { x, y, z, w } = pose.orientation;
        let position = DVec3::new(pose.position.x, pose.position.y, pose.position.z);
        Self::new(DQuat::from_xyzw(x, y, z, w), position)
    }
}
