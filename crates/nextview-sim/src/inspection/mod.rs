//! Views for the inspection of a part with a known CAD model.
//!
//! [`SurfaceDemands`] state the requirements on the surfaces of the part, [`KnownPart`] locates the part, and
//! [`InspectionViews`] plans the fewest views that meet all demands, and replans after each frame.

mod demand;
mod looks;
mod part;
mod planner;

pub use demand::{SurfaceDemand, SurfaceDemands};
pub use looks::PlacedPart;
pub use part::{KnownPart, PartFit};
pub use planner::InspectionViews;
