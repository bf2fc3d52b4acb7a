//! The scan itself, on a separate thread: planning takes longer than an image.

mod cloud;
mod markers;
mod octomap;
mod picture;
mod worker;

pub use worker::{Job, Order, State, WorkerReport, start};
