use schemars::JsonSchema;
use serde::Serialize;

/// A scan in the list of all.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct ScanSummary {
    /// Its name in paths.
    pub id: String,
    /// Name of the object.
    pub object: String,
    /// Whether it is under way.
    pub state: ScanState,
    /// Number of frames; none until an interrupted scan is resumed.
    pub n_frames: Option<usize>,
    /// When it was created: UTC, RFC 3339.
    pub created: String,
}

/// Whether a scan is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ScanState {
    /// It takes frames and gives out views.
    Running,
    /// It takes frames and gives out no views.
    Paused,
    /// Its results are on the disk: it takes no frames.
    Finished,
}
