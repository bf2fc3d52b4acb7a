//! A scanned part compared with its CAD model.
//!
//! [`inspect`] locates the part at any pose, and determines how far every measured point deviates from the
//! model, and how certain that is. Groups of deviating points are [defects](DefectRecord).
//! `docs/inspection.md` describes the method.

mod defects;
mod deviation;
mod inspection;
mod patches;
mod record;
mod seen;
mod text;
mod write;

pub use inspection::{Inspection, InspectionConfig, inspect, reference_of};
pub use record::{DefectRecord, InspectionRecord, SurfaceRecord};
pub use write::{INSPECTION_FILES, write_inspection};
