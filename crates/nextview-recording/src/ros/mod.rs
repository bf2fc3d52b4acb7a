//! The content of ROS 2 messages, from a file or from a network: images, optics, and where frames are to each
//! other.

mod camera_info;
mod compressed;
mod image;
mod transforms;

pub use camera_info::CameraInfo;
pub use compressed::CompressedImage;
pub use image::Image;
pub use transforms::{TransformError, TransformTree};
