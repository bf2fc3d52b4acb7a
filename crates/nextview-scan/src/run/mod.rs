//! The run: a scan from the first view to the last, pushed by the owner of the camera.

mod arm;
mod scan_state;
mod scan_run;
mod scan_facts;
mod warning;

pub use scan_state::{ScanState, Measured, ModelFrames};
pub use scan_run::{RunOptions, Next, ScanRun, TakenFrame};
