//! The configuration of a scan.

mod checks;
mod choices;
mod live;
mod load;
mod millimetres;
mod names;
#[cfg(feature = "simulated")]
mod noise;
mod planner;
mod planner_choice;
mod planner_name;
mod planner_properties;
mod positions;
mod provided;
mod reach;
mod reachable;
mod recording;
mod reference;
mod requests;
mod robot;
mod scan_config;
#[cfg(feature = "simulated")]
mod sensor;
#[cfg(feature = "simulated")]
mod sensor_name;
mod source;
mod source_keys;
mod turntable;
mod value;

pub use choices::{BoxRule, Profile, SizeOf, TableRule, UnitName, ViewRule, ViewSpaceName};
pub use live::LiveConfig;
pub use load::{merged, nested};
pub use names::Named;
#[cfg(feature = "simulated")]
pub use noise::{NoiseConfig, NoiseModel};
pub use planner_choice::PlannerChoice;
pub use planner_name::{NbvNetConfig, PlannerName};
pub use planner_properties::PlannerProperties;
pub use positions::Positions;
pub use provided::{PlannerProvider, ProvidedPlanner, provide_planners};
pub use reach::ReachConfig;
pub use recording::RecordingConfig;
pub use reference::{ReferenceConfig, ReferenceSurface};
pub use robot::RobotConfig;
pub use scan_config::{MapConfig, ModelConfig, ObjectBoxConfig, ScanConfig};
#[cfg(feature = "simulated")]
pub use sensor_name::SensorName;
pub use source::SourceConfig;
pub use turntable::TurntableConfig;
pub use value::read_value;
