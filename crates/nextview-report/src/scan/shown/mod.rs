//! The content of the 3D view except the measured points and the cameras.

mod candidate_gain;
mod expected;
mod looks;
mod model;
mod surface;
mod vertex;

pub use model::ShownModel;
pub(super) use surface::FusedFrames;
pub(crate) use vertex::ShownVertex;
