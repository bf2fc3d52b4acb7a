//! The ROS 2 messages of the node, field by field in the order of their definitions.

mod basic;
mod geometry;
mod inputs;
mod outputs;

pub use basic::{Bytes, Header, Text, Time};
pub use geometry::{Point, Pose, PoseStamped, Quaternion, Vector3};
pub use inputs::{CameraInfo, CompressedImage, Image, TfMessage, TriggerRequest};
pub use outputs::{
    ColorRgba, Duration, JointTrajectory, JointTrajectoryPoint, Marker, MarkerArray, Octomap, Path,
    PointCloud2, PointField, PoseArray, TriggerResponse,
};
