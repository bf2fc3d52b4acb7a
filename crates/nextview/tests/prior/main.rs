//! The learned prior and what is planned with it against slow and obvious twins, whatever the weights are.

#![allow(clippy::unwrap_used, reason = "clippy allows it in test functions, not in their helpers")]

#[path = "../common/mod.rs"]
mod common;
mod features;
mod gain;
mod planner;
mod synthetic;
