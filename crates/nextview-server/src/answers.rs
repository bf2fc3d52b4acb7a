//! Answers, and small request bodies.

use crate::scans::ScanSummary;
use nextview::session::StopReason;
use nextview_scan::{Fault, Guidance, ScanRecord, StepRecord, ViewRecord};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// State of the server.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Health {
    /// `ok`.
    pub status: &'static str,
    /// Version of nextview.
    pub version: &'static str,
}

/// State of a scan.
#[derive(Serialize, JsonSchema)]
pub(crate) struct ScanAnswer {
    #[serde(flatten)]
    pub summary: ScanSummary,
    /// Whether a proposed view must be accepted before it is returned.
    pub confirm_views: bool,
    /// The record so far; without measures of the model while the scan is in progress.
    pub record: ScanRecord,
    /// The damaged part of the journal, which was lost when the scan was resumed; `None` if nothing was
    /// damaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<String>,
}

/// An observed frame.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FrameAnswer {
    /// Whether the frame had been observed before: this is then its original record.
    pub duplicate: bool,
    #[serde(flatten)]
    pub step: StepRecord,
}

/// The next step.
#[derive(Serialize, JsonSchema)]
pub(crate) struct NextAnswer {
    pub state: NextState,
    /// The next view; `None` if there is none.
    pub view: Option<ViewRecord>,
    /// With `batch`, the views to take after it if nothing were learned on the way, in order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub following: Option<Vec<ViewRecord>>,
    /// Why the scan ended; `None` while it is in progress.
    pub stop_reason: Option<StopReason>,
}

/// The next step.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum NextState {
    /// Take a frame of the view.
    View,
    /// Wait until the view is accepted.
    Proposed,
    /// Wait until the scan is resumed.
    Paused,
    /// No view is left. Until the results are written, frames are still accepted.
    Finished,
}

impl NextAnswer {
    pub fn without_view(state: NextState, stop_reason: Option<StopReason>) -> Self {
        Self { state, view: None, following: None, stop_reason }
    }
}

/// A view that must not be proposed again.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Skip {
    /// Number of the view.
    pub view: usize,
    /// The reason.
    #[serde(default)]
    pub reason: String,
}

/// A proposed view that may be returned.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Accept {
    /// Number of the view; `None` for a first view that is no candidate.
    #[serde(default)]
    pub view: Option<usize>,
}

/// A finished scan.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FinishAnswer {
    /// The record, as in `record.json`.
    pub record: ScanRecord,
    /// The files of the results.
    pub files: Vec<String>,
    /// Results that could not be made, such as the cloud of a scan that saw nothing.
    pub problems: Vec<String>,
}

/// Pose of the camera.
#[derive(Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraPose {
    /// The rows of the 4 x 4 matrix that takes points from camera to world in metres.
    pub world_from_camera: [[f64; 4]; 4],
}

/// Actual and wanted pose of the camera.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct GuidanceAnswer {
    /// The rows of the 4 x 4 matrix that takes points from camera to world in metres.
    pub world_from_camera: [[f64; 4]; 4],
    /// The motion to the next view; `None` if the scan is over.
    pub guidance: Option<Guidance>,
}

/// Whether the camera's pose is known.
#[derive(Clone, Serialize, JsonSchema)]
pub(crate) struct Tracking {
    /// Whether the camera is lost.
    pub lost: bool,
    /// The remedy if the camera is lost.
    pub remedy: Option<String>,
}

/// Confirmation of a change.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Done {
    /// The resulting state of the scan.
    pub state: crate::scans::ScanPhase,
}

/// A deleted scan.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Deleted {
    /// Id of the scan.
    pub deleted: String,
}

/// Reads the record in a file.
pub(crate) fn record_of(bytes: &[u8]) -> Result<ScanRecord, Fault> {
    serde_json::from_slice(bytes).map_err(|error| Fault::data(error).within("record.json"))
}
