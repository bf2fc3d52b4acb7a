//! The record of a scan: all that front ends, tables and reports read.

mod build;
mod scan_record;
mod step_record;

pub use build::BuildIdentity;
pub use scan_record::{QualityMm, ScanRecord};
pub use step_record::StepRecord;
