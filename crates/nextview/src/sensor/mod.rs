//! Depth cameras: intrinsics with lens distortion, depth images, and frames (image, intrinsics and pose).
//!
//! Start with [`Frame`]: it is all a planner learns from a camera. Nothing here talks to a device.

mod depth_image;
mod distortion;
mod frame;
mod intrinsics;
mod lens_lanes;

pub use depth_image::{Depth, DepthImage};
pub use distortion::Distortion;
pub use frame::Frame;
pub use intrinsics::Intrinsics;
pub(crate) use lens_lanes::Points;
