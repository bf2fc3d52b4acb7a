//! Depth cameras: intrinsics with lens distortion, depth images, frames (image, intrinsics and pose),
//! matching colour images, and the specifications of common [sensors](Sensor).
//!
//! Start with [`Frame`]: it is a planner's only input from a camera. Nothing here talks to a device.

mod camera_axes;
mod color_image;
mod depth_image;
mod depth_noise;
mod depth_range;
mod distortion;
mod frame;
mod intrinsics;
mod lens_lanes;
mod preset;
mod surface_noise;
#[cfg(test)]
pub(crate) mod synthetic;

#[cfg(test)]
use crate::geometry::Pose;

pub use camera_axes::CameraAxes;
pub use color_image::ColorImage;
pub use depth_image::{Depth, DepthImage};
pub use depth_noise::DepthNoise;
pub use depth_range::DepthRange;
pub use distortion::Distortion;
pub use frame::Frame;
pub use intrinsics::{Intrinsics, Stretch};
pub(crate) use lens_lanes::Points;
pub use preset::{Principle, Sensor};
pub use surface_noise::SurfaceNoise;
