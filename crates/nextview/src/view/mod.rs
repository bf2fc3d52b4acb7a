//! View candidates: where the camera could go.
//!
//! Start with [`ViewSpace`]: an immutable, numbered list of camera poses. It is made by a [rule](generate) or read
//! from a [file](ViewSpace::read_csv), and [`Reach`] says which of them a robot can go to. [`KeepOut`] leads around the object on
//! the way from one to another, [`tour`] through many.

mod csv;
pub mod generate;
mod look_at;
mod path;
mod reach;
mod route;
mod tour;
mod view_space;

pub use look_at::look_at;
pub use path::KeepOut;
pub(crate) use path::MAX_TURN;
pub use reach::{Reach, ReachSphere};
pub(crate) use route::Route;
pub use tour::{detour, tour, tour_length};
pub use view_space::ViewSpace;
