//! Transforms between frames: `/tf` and `/tf_static`.

mod error;
mod motion;
#[cfg(test)]
mod tests;
mod tree;

pub use error::TransformError;
pub use tree::TransformTree;
