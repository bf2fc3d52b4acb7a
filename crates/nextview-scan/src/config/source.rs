//! Where the frames of a scan come from.

use super::{LiveConfig, RecordingConfig};
use crate::Fault;
use serde::{Serialize, Serializer};

/// Where the frames of a scan come from, with the settings of that source.
///
/// In files, it is the key `recording` or `live`; without both, frames are simulated.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SourceConfig {
    /// A simulated camera in front of a mesh.
    #[default]
    Simulated,
    /// Recorded frames.
    Recording(RecordingConfig),
    /// A user's camera, during the scan.
    Live(LiveConfig),
}

// The keys of a source.
#[derive(Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct SourceKeys<'a> {
    /// Uses recorded frames. Without this or `live`, frames are simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a RecordingConfig>,
    /// Uses frames from a user's camera during the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    live: Option<&'a LiveConfig>,
}

impl SourceConfig {
    /// Whether frames are simulated.
    pub fn is_simulated(&self) -> bool {
        *self == Self::Simulated
    }

    /// The settings of recorded frames; `None` for other frames.
    pub fn recording(&self) -> Option<&RecordingConfig> {
        match self {
            Self::Recording(recording) => Some(recording),
            Self::Simulated | Self::Live(_) => None,
        }
    }

    /// The settings of a user's camera; `None` for other frames.
    pub fn live(&self) -> Option<&LiveConfig> {
        match self {
            Self::Live(live) => Some(live),
            Self::Simulated | Self::Recording(_) => None,
        }
    }

    /// The settings of recorded frames, which replace a simulation. Fails for a user's camera.
    pub fn to_recording(&mut self) -> Result<&mut RecordingConfig, Fault> {
        if self.is_simulated() {
            *self = Self::Recording(RecordingConfig::default());
        }
        match self {
            Self::Recording(recording) => Ok(recording),
            Self::Simulated | Self::Live(_) => Err(Self::two()),
        }
    }

    /// The settings of a user's camera, which replaces a simulation. Fails for recorded frames.
    pub fn to_live(&mut self) -> Result<&mut LiveConfig, Fault> {
        if self.is_simulated() {
            *self = Self::Live(LiveConfig::default());
        }
        match self {
            Self::Live(live) => Ok(live),
            Self::Simulated | Self::Recording(_) => Err(Self::two()),
        }
    }

    /// The fault of two sources.
    pub(super) fn two() -> Fault {
        let fault = Fault::request("frames are either recorded or come from a user's camera");
        Fault { key: Some("live".to_owned()), ..fault }.with_remedy("leave out `recording` or `live`")
    }
}

impl Serialize for SourceConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SourceKeys { recording: self.recording(), live: self.live() }.serialize(serializer)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for SourceConfig {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SourceConfig".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        SourceKeys::json_schema(generator)
    }
}
