//! What is kept of a run of a campaign: a line of `runs.jsonl`.

use crate::scan::{QualityMm, ScanConfig};
use nextview::registration::Verdict;
use nextview::session::StopReason;
use serde::{Deserialize, Serialize};

/// One run, done or failed. Object, variant, seed and first view tell it from all others of its campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunRecord {
    /// The object's name: that of its file without the extension, or of the built-in object.
    pub object: String,
    /// The data set: the name of the folder the object's file is in, or `builtin`.
    pub data_set: String,
    /// The label of the planner and its parameters in the specification.
    pub variant: String,
    pub seed: u64,
    pub first_view: usize,
    /// Everything that decided the run.
    pub config: ScanConfig,
    /// Of this program.
    pub version: String,
    pub host: Host,
    pub result: RunResult,
}

/// Where a run took place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Host {
    pub name: String,
    /// The processor's name.
    pub cpu: String,
    /// Threads that the run had.
    pub n_threads: usize,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum RunResult {
    Done(Box<Measures>),
    /// The reason.
    Failed(String),
}

/// What was measured of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Measures {
    /// Object voxels at the finest voxel size.
    pub n_object_voxels: usize,
    /// Those that any candidate sees; none without baselines.
    pub n_reachable: Option<usize>,
    pub stop_reason: StopReason,
    /// A view each.
    pub steps: Vec<StepMeasures>,
    /// Share of the reachable object voxels seen after each of `config.views` views by random views (mean of many
    /// sequences) and by the clairvoyant planner; none without baselines.
    pub random_curve: Option<Vec<f64>>,
    pub clairvoyant_curve: Option<Vec<f64>>,
    /// Area under the curve of `seen` from random (0) to clairvoyant (1).
    pub skill: Option<f64>,
    /// Quality of the final cloud; none where it holds nothing of the object, and in campaigns of old.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cloud: Option<QualityMm>,
    /// Growth of the process's peak memory in the run; none where runs took place beside each other or the system does
    /// not tell.
    pub extra_memory_mb: Option<f64>,
}

/// What was measured after a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StepMeasures {
    /// Number of the view among the candidates; none for a first view that is none of them.
    pub view: Option<usize>,
    /// Voxel size in which the view was planned.
    pub voxel_size_m: f64,
    /// Occupied object voxels of the map at the finest voxel size, over object voxels.
    pub voxel_coverage: f64,
    /// Occupied voxels that are no object voxels.
    pub false_voxels: usize,
    /// Share of the reachable object voxels seen so far; none without baselines.
    pub seen: Option<f64>,
    /// The planner's estimate, before it took this view, of the share of what can be seen that had been seen; none for planners
    /// that do not tell, and in campaigns of old.
    #[serde(default)]
    pub estimated_seen_before: Option<f64>,
    /// Voxels that it expected the view to show anew.
    #[serde(default)]
    pub expected_new_voxels: Option<f64>,
    /// Share of the true surface with a measured point within 1, 2 and 5 mm.
    pub surface_1mm: f64,
    pub surface_2mm: f64,
    pub surface_5mm: f64,
    /// How far the image's points are from where they are, for its pose: root mean square; none where poses are right, and in
    /// campaigns of old.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misplaced_mm: Option<f64>,
    /// What came of aligning the image, and the share of its points on the known surface; none without registration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<Verdict>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overlap: Option<f64>,
    /// Entropy in the box at the finest voxel size.
    pub entropy_nats: f64,
    /// The same over that of an unknown box.
    pub entropy_share: f64,
    /// Length of the path so far.
    pub path_length_m: f64,
    /// Length of the ways so far around the object, and the time that they take; none in campaigns of old.
    #[serde(default)]
    pub way_m: Option<f64>,
    #[serde(default)]
    pub move_time_s: Option<f64>,
    pub plan_time_ms: f64,
    pub map_time_ms: f64,
    pub render_time_ms: f64,
}
