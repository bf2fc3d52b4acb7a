//! What the node knows of its camera, from the messages that come in.

mod capture;
mod incoming;
mod rest;
mod whereabouts;

pub use capture::Taken;
pub use incoming::Camera;
