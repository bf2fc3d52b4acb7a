//! The learned planners of others, and the data that they are trained on.

mod dataset;
mod nbv_net;
mod nbv_regression;
mod pc_nbv;
