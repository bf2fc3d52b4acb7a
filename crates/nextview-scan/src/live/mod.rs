//! A scan with a user's camera, from a configuration to the results: what a server, a ROS node and Python
//! drive.

mod fingerprint;
mod guidance;
mod live_frame;
mod live_scan;
mod tracking;
mod whereabouts;

pub use guidance::Guidance;
pub use live_frame::LiveFrame;
pub use live_scan::LiveScan;
