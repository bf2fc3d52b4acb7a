//! Learned planners of the literature, with their weights.
//!
//! Each planner is a module; [`nbv_net::NbvNet`] is a [`ViewPlanner`](nextview::planner::ViewPlanner). They
//! are a crate of their own because of the weights: 3 MB.

pub mod nbv_net;
