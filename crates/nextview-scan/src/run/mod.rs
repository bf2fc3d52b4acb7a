//! The run: a scan from the first view to the last, pushed by the owner of the camera.

mod arm;
mod scan_facts;
mod scan_run;
mod scan_state;
mod warning;

pub use scan_run::{Next, RunOptions, ScanRun, TakenFrame};
pub use scan_state::{Measured, ModelFrames, ScanState};
