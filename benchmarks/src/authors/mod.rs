//! The program of the paper's authors (profile `authors-code`), slip by slip.
//!
//! Written from a description of their program's behaviour, without any code of theirs, and on the library
//! where that computes the same. Each [`Slips`] field is a deviation of the program from the paper.
//! `docs/reproduction.md` has the results, made by the program `authors_code`.
//!
//! Found by fitting to the recorded maps and networks, because no description states it: the roll of the
//! cameras ([`camera`]), the distance between the rays of a view ([`outline`]), and the layers of voxels just
//! outside the box in which rays also end ([`recording::RecordedRun::created`]).

/// The camera's roll.
pub mod camera;
/// The flow's voxels, views and gains.
pub mod flow;
/// The value of voxels along rays.
pub mod gain;
/// Runs with an increasing number of repaired slips.
pub mod ladder;
/// The map and its bands of probability.
pub mod map;
/// The box's outline in an image.
pub mod outline;
/// Planning rays.
pub mod rays;
/// The recorded run.
pub mod recording;
/// Measurements of the authors' program.
pub mod reference;
/// The results as Markdown.
pub mod report;
/// A run of ten scans.
pub mod run;
/// The virtual camera.
pub mod sensor;
mod slips;

pub use slips::{Repair, Slips};
