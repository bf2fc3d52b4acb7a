//! The occupancy map.

mod log_odds;
pub mod octree;

pub use log_odds::{LogOdds, Occupancy, SensorModel, entropy};
