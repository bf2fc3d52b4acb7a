//! A single scan as a library: configuration, sources of frames, the run, its journal, the final model and
//! the record.
//!
//! It prints nothing, exits no process and names no program options: front ends do. Errors are returned as
//! [`Fault`]s. Start with [`ScanRun`], which is pushed and never blocks: the owner of the camera calls
//! [`next`](ScanRun::next), takes the picture and [`push`](ScanRun::push)es it. [`LiveScan`] covers such a
//! run from the configuration to the results.
//!
//! ```text
//! source ──frame──▶ ScanRun::push ──▶ journal ──▶ Session::observe ──▶ Evaluator ──▶ StepRecord ──▶ listeners
//!   ▲                                                                              (program, page, ROS, Python)
//!   └──── ScanRun::next: Replay(frame) | Capture(view) | Stop(reason) ◀── Session::decide
//! ```

mod config;
mod earlier_scan;
mod fault;
pub mod files;
mod journal;
mod live;
pub mod memory;
mod model;
#[cfg(feature = "process")]
pub mod process;
mod record;
mod results;
mod run;
mod source;

pub use config::*;
pub use fault::{Cause, Fault, FaultKind, Faults, FilePosition};
#[cfg(fuzzing)]
pub use journal::fuzzing;
pub use journal::{Damage, Interrupted, Journal, JournalEntry, Kept, KeptFrame, ScanJournal, SkippedView};
pub use live::{Guidance, LiveFrame, LiveScan};
pub use model::FinalModel;
pub use record::{
    BatchRecord, BatchViewRecord, BuildIdentity, HandEyeRecord, OtherBodyRecord, PlacementRecord, QualityMm,
    ScanRecord, StepRecord, TurnRecord, ViewRecord, WaypointRecord, pose_of_rows, rows_of_pose,
};
#[cfg(feature = "simulated")]
pub use results::SavedModel;
pub use results::{
    FRAMES_FOLDER, MapSummary, RESULT_FILES, Results, SavedMap, ScanFolder, begin_results, convert_map,
    result_file, result_folder, write_results,
};
pub use run::{Measured, ModelFrames, Next, RunOptions, ScanRun, ScanState, TakenFrame};
pub use source::*;

/// The name of an object without `builtin:`, folders and extension.
pub fn short_name(object: &str) -> String {
    let name = object.strip_prefix("builtin:").unwrap_or(object);
    std::path::Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
