use super::basic::{Bytes, Header, Time};
use super::geometry::{Point, Pose, PoseStamped, Vector3};
use serde::{Deserialize, Serialize};

/// The answer of `std_srvs/srv/Trigger`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    pub success: bool,
    pub message: String,
}

impl ros2_client::Message for TriggerResponse {}

/// `geometry_msgs/msg/PoseArray`.
#[derive(Clone, Debug, Serialize)]
pub struct PoseArray {
    pub header: Header,
    pub poses: Vec<Pose>,
}

/// `nav_msgs/msg/Path`.
#[derive(Clone, Debug, Serialize)]
pub struct Path {
    pub header: Header,
    pub poses: Vec<PoseStamped>,
}

/// `octomap_msgs/msg/Octomap`.
#[derive(Clone, Debug, Serialize)]
pub struct Octomap {
    pub header: Header,
    pub binary: bool,
    pub id: String,
    pub resolution: f64,
    pub data: Bytes,
}

/// `sensor_msgs/msg/PointField`.
#[derive(Clone, Debug, Serialize)]
pub struct PointField {
    pub name: String,
    pub offset: u32,
    pub datatype: u8,
    pub count: u32,
}

/// `sensor_msgs/msg/PointCloud2`.
#[derive(Clone, Debug, Serialize)]
pub struct PointCloud2 {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub fields: Vec<PointField>,
    pub is_bigendian: bool,
    pub point_step: u32,
    pub row_step: u32,
    pub data: Bytes,
    pub is_dense: bool,
}

/// `std_msgs/msg/ColorRGBA`.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ColorRgba {
    pub r: f32,
    pub g: f32,
    pub b: f32,
    pub a: f32,
}

/// `builtin_interfaces/msg/Duration`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Duration {
    pub sec: i32,
    pub nanosec: u32,
}

impl Duration {
    /// Converts from a non-negative time in seconds.
    pub fn from_seconds(seconds: f64) -> Self {
        let Time { sec, nanosec } = Time::from_seconds(seconds);
        Self { sec, nanosec }
    }
}

/// `trajectory_msgs/msg/JointTrajectory`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointTrajectory {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub points: Vec<JointTrajectoryPoint>,
}

/// `trajectory_msgs/msg/JointTrajectoryPoint`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JointTrajectoryPoint {
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    pub accelerations: Vec<f64>,
    pub effort: Vec<f64>,
    pub time_from_start: Duration,
}

/// `visualization_msgs/msg/MeshFile`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MeshFile {
    pub filename: String,
    pub data: Bytes,
}

/// `visualization_msgs/msg/Marker`, as of ROS 2 Humble and later.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Marker {
    pub header: Header,
    pub ns: String,
    pub id: i32,
    pub kind: i32,
    pub action: i32,
    pub pose: Pose,
    pub scale: Vector3,
    pub color: ColorRgba,
    pub lifetime: Duration,
    pub frame_locked: bool,
    pub points: Vec<Point>,
    pub colors: Vec<ColorRgba>,
    pub texture_resource: String,
    /// `sensor_msgs/msg/CompressedImage`, empty.
    pub texture: (Header, String, Bytes),
    pub uv_coordinates: Vec<(f32, f32)>,
    pub text: String,
    pub mesh_resource: String,
    pub mesh_file: MeshFile,
    pub mesh_use_embedded_materials: bool,
}

/// `visualization_msgs/msg/MarkerArray`.
#[derive(Clone, Debug, Serialize)]
pub struct MarkerArray {
    pub markers: Vec<Marker>,
}
