//! PC-NBV (Zeng, Zhao & Liu, *PC-NBV: a point cloud based deep network for efficient next best view
//! planning*, IROS 2020): a network that takes points of the seen surface and the visited views, and predicts
//! for each of 33 views the share of new surface that it would show.
//!
//! Start with the planner [`PcNbv`]; its input is a [`Cloud`], its output a number for each of the [`views`].
//! The architecture is the paper's with smaller layers; `docs/methods/pc-nbv.md` states them, and describes
//! the training of the weights.

mod cloud;
mod network;
mod planner;
pub mod views;

pub use cloud::Cloud;
pub use network::Network;
pub use planner::PcNbv;
