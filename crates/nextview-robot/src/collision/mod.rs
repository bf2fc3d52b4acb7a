//! Collisions of an arm with itself, solids, tables and blocked voxels. Start with [`Checker`].
//!
//! Distances are lower bounds: errors cause false contacts, never missed ones. The algorithm is our own.
//! Libraries that have one return an upper bound (the distance of the nearest points found), and take longer
//! to build than the rest of this crate.

mod checker;
mod contact;
mod error;
mod gjk;
mod obstacle;
mod simplex;
mod solid;
mod sweep;
mod touching;
mod voxels;

pub use checker::{Attachment, Checker};
pub use contact::Contact;
pub use error::CellError;
pub use obstacle::{Obstacle, ObstacleKind};
pub use touching::touching_links;
pub use voxels::BlockedVoxels;
