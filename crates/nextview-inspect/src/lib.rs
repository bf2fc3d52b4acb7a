//! A scanned part beside its CAD model.
//!
//! [`inspect`] finds where the part is, from anywhere, and says of every measured point how far it is from
//! the model and how sure that is; points that deviate together are [defects](DefectRecord).
//! `docs/inspection.md` describes the method.

mod defects;
mod deviation;
mod fit;
mod inspection;
mod patches;
mod record;
mod text;
mod write;

pub use inspection::{Inspection, InspectionConfig, inspect};
pub use record::{DefectRecord, InspectionRecord};
pub use write::{INSPECTION_FILES, write_inspection};
