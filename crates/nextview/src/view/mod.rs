//! View candidates: where the camera could go.
//!
//! Start with [`ViewSpace`]: an immutable, numbered list of camera poses. It is made by a [rule](generate) or
//! read from a [file](ViewSpace::read_csv). [`Reach`] states which of them a robot can reach.

mod csv;
pub mod generate;
mod look_at;
mod reach;
mod view_space;

pub use look_at::look_at;
pub use reach::{Reach, ReachSphere, Reachability};
pub use view_space::ViewSpace;
