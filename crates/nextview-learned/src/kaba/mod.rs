//! View planning by reinforcement learning (Kaba, Uzunbas & Lim, *A reinforcement learning approach to the
//! view planning problem*, CVPR 2017): a view is worth its gain less a weight times the boundary that it
//! leaves, and a learned policy chooses the weight before each view.
//!
//! Start with the planner [`Kaba`]. A [`Surveyor`] measures what the policy decides on, and [`Policy`] is
//! what was learned. `docs/methods/kaba.md` states the formulas and how the policy was trained.

mod boundary;
mod planner;
mod policy;
mod survey;

pub use planner::Kaba;
pub use policy::{BOUNDARY_WEIGHTS, Policy};
pub use survey::{N_FEATURES, Survey, Surveyor};
