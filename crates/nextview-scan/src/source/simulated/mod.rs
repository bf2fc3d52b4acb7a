//! A simulated camera in front of a true object.

mod baselines;
mod object;
mod quality;
mod simulated_object;
mod simulation;
mod truth_bytes;
mod truth_cache;
mod turn;

pub use baselines::{Baselines, Truth};
pub(super) use quality::measure_model;
pub use simulated_object::SimulatedObject;
pub use simulation::Simulation;
pub use truth_cache::TruthCache;
