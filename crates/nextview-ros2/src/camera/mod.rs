//! The state of the node's camera, from incoming messages.

mod capture;
mod incoming;
mod rest;
mod whereabouts;

pub use capture::Taken;
pub use incoming::Camera;
