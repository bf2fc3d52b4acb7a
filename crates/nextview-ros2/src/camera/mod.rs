//! The state of the node's camera, from incoming messages.

mod capture;
mod incoming;
mod pose_history;
mod rest;

pub use capture::PosedImage;
pub use incoming::Camera;
