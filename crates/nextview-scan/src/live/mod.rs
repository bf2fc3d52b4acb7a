//! A scan with a user's camera, from configuration to results: driven by the server, the ROS node and Python.

mod fingerprint;
mod guidance;
mod known_poses;
mod live_frame;
mod live_scan;
mod tracking;

pub use guidance::Guidance;
pub use live_frame::LiveFrame;
pub use live_scan::LiveScan;
