//! The content of ROS 2 messages, from a file or a network: images, optics, and transforms between frames.

mod camera_info;
mod compressed;
mod image;
mod transforms;

pub use camera_info::CameraInfo;
pub use compressed::CompressedImage;
pub use image::Image;
pub use transforms::{TransformError, TransformTree};
