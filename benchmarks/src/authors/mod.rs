//! The program of the paper's authors (profile `authors-code`), slip by slip.
//!
//! Written from a description of what their program does, without any code of theirs, over the library where
//! that computes the same. Each [`Slips`] field is a place where the program does otherwise than the paper
//! says. `docs/reproduction.md` has the results, the program `authors_code` makes them.
//!
//! Found by fitting to the recorded maps and networks, because no description says it: the roll of the
//! cameras ([`camera`]), the distance between the rays of a view ([`outline`]), and the layers of voxels just
//! outside the box in which rays end as well ([`recording::Recording::created`]).

/// The camera's roll.
pub mod camera;
/// The flow's voxels, views and gains.
pub mod flow;
/// The worth of what rays cross.
pub mod gain;
/// Runs with fewer and fewer slips.
pub mod ladder;
/// The map and its bands of probability.
pub mod map;
/// The box's outline in an image.
pub mod outline;
/// Planning rays.
pub mod rays;
/// The recorded run.
pub mod recording;
/// What was measured of the authors' program.
pub mod reference;
/// The results as Markdown.
pub mod report;
/// A run of ten scans.
pub mod run;
/// The virtual camera.
pub mod sensor;
mod slips;

pub use slips::{Repair, Slips};

/// What fails here says where and why.
pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;
