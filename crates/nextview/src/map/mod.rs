//! The occupancy map.

mod log_odds;

pub use log_odds::{LogOdds, Occupancy, SensorModel, entropy};
