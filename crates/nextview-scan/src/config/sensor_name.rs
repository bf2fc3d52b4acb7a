use serde::{Deserialize, Serialize};
use std::path::Path;

/// The name of a known sensor, or a `.toml` file with the differences of another sensor from a known one: the
/// key `like` names the known one, and the tables `camera` and `noise.depth` have the keys of a
/// configuration.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct SensorName(pub String);

impl SensorName {
    /// The file; `None` if it is a name.
    pub fn file(&self) -> Option<&Path> {
        self.0.ends_with(".toml").then(|| Path::new(&self.0))
    }
}
