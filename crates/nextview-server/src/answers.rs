//! What is answered, and what small bodies hold.

use crate::scans::ScanSummary;
use nextview::session::StopReason;
use nextview_scan::{Fault, Guidance, ScanRecord, StepRecord, ViewRecord};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The server runs.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Health {
    /// `ok`.
    pub status: &'static str,
    /// Version of nextview.
    pub version: &'static str,
}

/// A scan.
#[derive(Serialize, JsonSchema)]
pub(crate) struct ScanAnswer {
    #[serde(flatten)]
    pub summary: ScanSummary,
    /// Whether a proposed view must be accepted before it is given out.
    pub confirm_views: bool,
    /// The record so far; without the measures of a model while the scan is under way.
    pub record: ScanRecord,
    /// What was damaged in its journal, and lost, when the scan was resumed; none if nothing was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<String>,
}

/// A frame that was taken in.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FrameAnswer {
    /// Whether it had been taken in before: then this is its record of then.
    pub duplicate: bool,
    #[serde(flatten)]
    pub step: StepRecord,
}

/// What to do next.
#[derive(Serialize, JsonSchema)]
pub(crate) struct NextAnswer {
    pub state: NextState,
    /// The view; none where there is none.
    pub view: Option<ViewRecord>,
    /// With `batch`, the views to take after it if nothing were learned on the way, in order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub following: Option<Vec<ViewRecord>>,
    /// Why the scan is over; none while it is under way.
    pub stop_reason: Option<StopReason>,
}

/// What to do next.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum NextState {
    /// Take a frame of the view.
    View,
    /// Wait until the view is accepted.
    Proposed,
    /// Wait until the scan is continued.
    Paused,
    /// No view is left. Unless the results are written, frames are taken still.
    Finished,
}

impl NextAnswer {
    pub fn without_view(state: NextState, stop_reason: Option<StopReason>) -> Self {
        Self { state, view: None, following: None, stop_reason }
    }
}

/// A view that is not to be proposed again.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Skip {
    /// Its number.
    pub view: usize,
    /// Why.
    #[serde(default)]
    pub reason: String,
}

/// A proposed view that may be given out.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Accept {
    /// Its number; none of a first view that is no candidate.
    #[serde(default)]
    pub view: Option<usize>,
}

/// A scan that is finished.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FinishAnswer {
    /// The record, as in `record.json`.
    pub record: ScanRecord,
    /// The files of the results.
    pub files: Vec<String>,
    /// What could not be made, such as the cloud of a scan that saw nothing.
    pub problems: Vec<String>,
}

/// Where the camera is.
#[derive(Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Place {
    /// The rows of the 4 x 4 matrix that takes points of the camera to the world; metres.
    pub world_from_camera: [[f64; 4]; 4],
}

/// Where the camera is, and where it should go.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct GuidanceAnswer {
    /// The rows of the 4 x 4 matrix that takes points of the camera to the world; metres.
    pub world_from_camera: [[f64; 4]; 4],
    /// The way to the next view; none if the scan is over.
    pub guidance: Option<Guidance>,
}

/// Whether it is known where the camera is.
#[derive(Clone, Serialize, JsonSchema)]
pub(crate) struct Tracking {
    /// Whether it is not.
    pub lost: bool,
    /// What to do then.
    pub remedy: Option<String>,
}

/// It is done.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Done {
    /// Whether the scan is under way now.
    pub state: crate::scans::ScanState,
}

/// A scan that is gone.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Deleted {
    /// Its id.
    pub deleted: String,
}

/// The record of a file.
pub(crate) fn record_of(bytes: &[u8]) -> Result<ScanRecord, Fault> {
    serde_json::from_slice(bytes).map_err(|error| Fault::data(error).within("record.json"))
}
