//! View planning by reinforcement learning (Kaba, Uzunbas & Lim, *A reinforcement learning approach to the
//! view planning problem*, CVPR 2017): the value of a view is its gain minus a weight times the boundary it
//! leaves, and a learned policy chooses the weight before each view.
//!
//! Start with the planner [`Kaba`]. A [`Surveyor`] measures the policy's input, and [`Policy`] is the learned
//! policy. `docs/methods/kaba.md` states the formulas and describes the training.

mod boundary;
mod planner;
mod policy;
mod survey;

pub use planner::Kaba;
pub use policy::{BOUNDARY_WEIGHTS, Policy};
pub use survey::{KabaSurvey, N_FEATURES, Surveyor};
