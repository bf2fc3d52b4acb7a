//! The record of a scan: the input of front ends, tables and reports.

mod batch_record;
mod build;
mod hand_eye_record;
mod placement_record;
mod pose_matrix;
mod quality_mm;
mod read;
mod scan_record;
mod step_record;
mod view_record;

pub use batch_record::{BatchRecord, BatchViewRecord};
pub use build::BuildIdentity;
pub use hand_eye_record::HandEyeRecord;
pub use placement_record::{PlacementRecord, TurnRecord};
pub use pose_matrix::{pose_of_rows, rows_of_pose};
pub use quality_mm::QualityMm;
pub use scan_record::{OtherBodyRecord, ScanRecord};
pub use step_record::StepRecord;
pub use view_record::{ViewRecord, WaypointRecord};

use std::time::Duration;

/// A time in the unit of records.
pub(crate) fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
