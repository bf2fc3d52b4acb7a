//! Views for the inspection of a part whose CAD model is known.
//!
//! [`SurfaceDemands`] say how the surfaces of the part are to be seen, [`KnownPart`] finds where the part is,
//! and [`InspectionViews`] plans the fewest views that show all as demanded, and again after each frame.

mod demand;
mod looks;
mod part;
mod planner;

pub use demand::{SurfaceDemand, SurfaceDemands};
pub use looks::PlacedPart;
pub use part::{KnownPart, PartFit};
pub use planner::InspectionViews;
