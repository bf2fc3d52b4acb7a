//! How the camera gets from view to view: timed poses around the object and above its table.
//!
//! Start with [`Trajectory`], or ask a [session](crate::session::Session::trajectory_to) for one. [`KeepOut`]
//! gives the shortest path around the object, [`tour`] the order of a short path through many positions.
//! Robot joints and other obstacles are not modelled.

mod config;
mod long_tour;
mod path;
mod profile;
mod route;
mod tour;
mod track;
mod trajectory;
mod waypoint;

pub use config::MotionConfig;
pub use path::KeepOut;
pub use profile::SpeedProfile;
pub(crate) use tour::tour_unless;
pub use tour::{detour, tour, tour_length};
pub use trajectory::{Surroundings, Trajectory};
pub use waypoint::Waypoint;
