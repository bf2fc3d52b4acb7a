//! Learned planners of the literature, with their weights.
//!
//! Each planner is a module; [`nbv_net::NbvNet`] and [`kaba::Kaba`] are
//! [`ViewPlanner`](nextview::planner::ViewPlanner)s. They are a crate of their own because of the weights: 3
//! MB.

pub mod kaba;
pub mod nbv_net;
