//! Information gains: what a ray is worth.

mod local_gain;
mod nearest;
mod object_probability;

pub use local_gain::LocalGain;
pub use object_probability::object_probability;
