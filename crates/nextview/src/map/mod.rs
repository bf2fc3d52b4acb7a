//! The occupancy map: the measured state of the world.
//!
//! Start with [`OccupancyMap`]; its `integrate` adds scans, and planning reads a [`Snapshot`]. The
//! crate `nextview-octomap` reads and writes maps as files. Nothing here knows about views or gains.

mod brick;
mod frontier;
mod integrate;
mod integration;
mod key_box;
mod log_odds;
mod marks;
mod occupancy_map;
mod scan;
mod scan_size;
mod snapshot;

pub use frontier::frontier;
pub use integration::{Background, Integration, MapUpdate, RayRule};
pub use log_odds::{LogOdds, Occupancy, SensorModel, entropy};
pub use occupancy_map::OccupancyMap;
pub use snapshot::Snapshot;
