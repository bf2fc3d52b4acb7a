//! The simulated side of next-best-view planning: meshes, objects that need no file, and a depth camera that looks
//! at them. Nothing here plans.

pub mod builtin;
pub mod camera;
mod error;
pub mod mesh;

pub use error::SimError;
