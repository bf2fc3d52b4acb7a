//! The run: a scan from the first view to the last, pushed by the owner of the camera.

mod arm;
mod finished;
mod scan_run;
mod stated;
mod warning;

pub use finished::{FinishedScan, Measured, ModelFrames};
pub use scan_run::{Begin, Next, ScanRun, TakenFrame};
