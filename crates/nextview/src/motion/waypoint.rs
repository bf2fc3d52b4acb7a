use crate::geometry::Pose;

/// A pose of a [trajectory](super::Trajectory) and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Seconds since the start of the trajectory.
    pub time: f64,
    /// Pose of the camera at that time.
    pub world_from_camera: Pose,
}
