//! Learned planners from the literature, with their weights.
//!
//! Each planner is a module; [`nbv_net::NbvNet`], [`nbv_regression::NbvRegression`], [`pc_nbv::PcNbv`] and
//! [`kaba::Kaba`] are [`ViewPlanner`](nextview::planner::ViewPlanner)s. They are a separate crate because of
//! the weights: 5 MB.

#[cfg(feature = "dataset")]
pub mod dataset;
pub mod fixed_views;
mod grid;
mod grid_network;
pub mod kaba;
mod layers;
pub mod nbv_net;
pub mod nbv_regression;
pub mod pc_nbv;
mod weights;

pub use grid::Grid;
pub use weights::{TensorShape, WeightsError};
