//! The quality of a scan's model against the true surface. The formulas and their sources are in
//! `docs/measures.md`.
//!
//! Start with [`TrueSurface`]. If the first pose of a scan is wrong, its model is [aligned](align) once.

mod alignment;
mod reachable;
mod scores;
mod true_surface;

pub use alignment::align;
pub use reachable::ReachableSurface;
pub use scores::{Completeness, Quality, TOLERANCES};
pub use true_surface::TrueSurface;
