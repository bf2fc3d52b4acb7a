//! A scanned part beside its CAD model.
//!
//! [`inspect`] finds where the part is, from anywhere, and says of every measured point how far it is from
//! the model and how certain that is; points that deviate together are [defects](DefectRecord).
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
