use schemars::JsonSchema;
use serde::Serialize;

/// An entry in the list of scans.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct ScanSummary {
    /// Id of the scan in paths.
    pub id: String,
    /// Name of the object.
    pub object: String,
    /// State of the scan.
    pub state: ScanPhase,
    /// Number of frames; `None` until an interrupted scan is resumed.
    pub n_frames: Option<usize>,
    /// Time of creation: UTC, RFC 3339.
    pub created: String,
}

/// State of a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ScanPhase {
    /// Accepts frames and returns views.
    Running,
    /// Accepts frames and returns no views.
    Paused,
    /// Its results are on the disk: it accepts no frames.
    Finished,
}
