//! What the 3D view shows of a scan beside its measured points and its cameras.

mod candidate_gain;
mod expected;
mod looks;
mod model;
mod surface;
mod vertex;

pub use model::ShownModel;
pub(super) use surface::FusedFrames;
pub(crate) use vertex::ShownVertex;
