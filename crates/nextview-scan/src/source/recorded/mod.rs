//! Recorded frames.

mod recorded_scan;
#[cfg(feature = "simulated")]
mod true_shape;

pub use recorded_scan::RecordedScan;
