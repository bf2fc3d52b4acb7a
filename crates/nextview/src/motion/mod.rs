//! How the camera gets from view to view: poses with times, around the object and above its table.
//!
//! Start with [`Way`], or ask a [session](crate::session::Session::way_to) for one. What a robot's joints do on the way, and what
//! else stands around, is not known here.

mod config;
mod profile;
mod track;
mod way;

pub use config::MotionConfig;
pub use profile::Profile;
pub use way::{Surroundings, Way, Waypoint};
