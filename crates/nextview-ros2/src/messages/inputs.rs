use super::basic::{Bytes, Header};
use super::geometry::Pose;
use nextview_recording::ros;
use serde::{Deserialize, Serialize};

/// `sensor_msgs/msg/Image`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Image {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub encoding: String,
    pub is_bigendian: u8,
    pub step: u32,
    pub data: Bytes,
}

impl Image {
    pub fn content(&self) -> ros::Image<'_> {
        ros::Image {
            width: self.width,
            height: self.height,
            encoding: &self.encoding,
            is_big_endian: self.is_bigendian != 0,
            step: self.step,
            data: &self.data.0,
        }
    }
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    pub data: Bytes,
}

impl CompressedImage {
    pub fn content(&self) -> ros::CompressedImage<'_> {
        ros::CompressedImage { format: &self.format, data: &self.data.0 }
    }
}

/// `sensor_msgs/msg/CameraInfo` up to the matrix `k`; the rest is unused.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CameraInfo {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub distortion_model: String,
    pub d: Vec<f64>,
    pub k: [f64; 9],
}

impl CameraInfo {
    pub fn content(&self) -> ros::CameraInfo<'_> {
        ros::CameraInfo {
            width: self.width,
            height: self.height,
            distortion_model: &self.distortion_model,
            d: &self.d,
            k: self.k,
        }
    }
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Pose,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TfMessage {
    pub transforms: Vec<TransformStamped>,
}

/// The request of `std_srvs/srv/Trigger`: empty, which takes one byte.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TriggerRequest {
    pub structure_needs_at_least_one_member: u8,
}

impl ros2_client::Message for TriggerRequest {}
