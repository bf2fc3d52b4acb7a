//! Research programs: the evidence for decisions that the documentation explains.
//!
//! The programs `questions`, `ceiling` and `seconds` compare planners on [objects with known
//! truth](known_object). The program `purposes` compares planners by the [needs of scan purposes](needs), and
//! `truth` compares the exact object voxels with sampled ones. Nothing depends on this crate.

pub mod known_object;
pub mod needs;
