//! The state of the node's camera, from incoming messages.

mod capture;
mod incoming;
mod rest;
mod pose_history;

pub use capture::PosedImage;
pub use incoming::Camera;
