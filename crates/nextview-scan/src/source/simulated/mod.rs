//! A simulated camera before a true object.

mod baselines;
mod object;
mod quality;
mod simulated_object;
mod simulation;

pub use baselines::{Baselines, Truth};
pub(super) use quality::quality_mm;
pub use simulated_object::SimulatedObject;
pub use simulation::Simulation;
