//! The scan itself, on a thread of its own: planning takes longer than an image.

mod cloud;
mod markers;
mod octomap;
mod picture;
mod worker;

pub use worker::{Job, Order, Report, State, start};
