use super::StepRecord;
use crate::{PlannerName, Profile};
use nextview::session::{OtherBody, StopReason};
use serde::{Deserialize, Serialize};

/// A scan, finished or under way: `record.json`, and what `nextview scan --json` prints.
///
/// Quantities that are not known are left out. Two equal scans differ in the entries that end in `_time_ms`
/// and in `peak_memory_mb` only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ScanRecord {
    /// Name of the object: of its file without the extension, or of the built-in object.
    pub object: String,
    /// The planner.
    pub planner: PlannerName,
    /// The named set of defaults that the configuration came from.
    pub profile: Profile,
    /// Seed of the random planner and the random shell.
    pub seed: u64,
    /// Why the scan ended; none while it is under way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_reason: Option<StopReason>,
    /// Edge of the finest voxels.
    pub voxel_size_m: f64,
    /// Number of view candidates.
    pub candidates: usize,
    /// Number of views taken: that of `steps`.
    pub views: usize,

    /// Voxels that hold some of the true surface; none where the true object is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object_voxels: Option<usize>,
    /// Those of them that any candidate sees; this and the next four none without baselines. Of a recording
    /// whose truth is known: samples of the surface that any frame shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_voxels: Option<usize>,
    /// Share, 0..=1, of the reachable surface that was seen at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_coverage: Option<f64>,
    /// The same after each view for random views: mean of many sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_curve: Option<Vec<f64>>,
    /// 5th percentile of these sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_low_curve: Option<Vec<f64>>,
    /// 95th percentile of these sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_high_curve: Option<Vec<f64>>,
    /// The same after each view for the planner that knows the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clairvoyant_curve: Option<Vec<f64>>,
    /// Area under the curve of `reachable_coverage` on the scale from random views (0) to the clairvoyant
    /// planner (1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skill: Option<f64>,

    /// Length of the straight path through the positions of all views.
    pub path_length_m: f64,
    /// Length of the trajectory around the object and above its table.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for it.
    pub trajectory_time_s: f64,

    /// Mean distance from the points of the final cloud to the true surface; this and the six after it none
    /// where the truth is not known or the cloud holds nothing of the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_accuracy_mean_mm: Option<f64>,
    /// Median of these distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_accuracy_median_mm: Option<f64>,
    /// 95th percentile of these distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_accuracy_p95_mm: Option<f64>,
    /// Share, 0..=1, of the true surface with a point of the cloud within 1 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_1mm: Option<f64>,
    /// The same within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_2mm: Option<f64>,
    /// The same within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_5mm: Option<f64>,
    /// Mean distance from the true surface to the cloud.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_mean_mm: Option<f64>,
    /// The same seven of the final mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_accuracy_mean_mm: Option<f64>,
    /// See `cloud_accuracy_median_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_accuracy_median_mm: Option<f64>,
    /// See `cloud_accuracy_p95_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_accuracy_p95_mm: Option<f64>,
    /// See `cloud_completeness_1mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_completeness_1mm: Option<f64>,
    /// See `cloud_completeness_2mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_completeness_2mm: Option<f64>,
    /// See `cloud_completeness_5mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_completeness_5mm: Option<f64>,
    /// See `cloud_completeness_mean_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_completeness_mean_mm: Option<f64>,

    /// Frames and poses that were left out of the recording, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub skipped: Vec<String>,
    /// Bodies beside the object, nearest first, which do not belong to it; where the box grows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub other_bodies: Vec<OtherBodyRecord>,
    /// What else is odd in the recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Time to compute the baselines, apart from the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline_time_ms: Option<f64>,
    /// The most memory that the process ever held; none where the system does not report it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_memory_mb: Option<f64>,

    /// The views, in the order in which they were taken.
    pub steps: Vec<StepRecord>,
}

/// A body that was seen beside the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OtherBodyRecord {
    /// Middle of the box around its measured points, in the world.
    pub center_m: [f64; 3],
    /// Size of that box.
    pub size_m: [f64; 3],
    /// Its distance from the object: with a larger `object_box.max_gap_m`, it belongs to the object.
    pub gap_m: f64,
}

impl From<OtherBody> for OtherBodyRecord {
    fn from(OtherBody { bounds, gap }: OtherBody) -> Self {
        Self { center_m: bounds.center().to_array(), size_m: bounds.size().to_array(), gap_m: gap }
    }
}

/// How good a cloud or a mesh is beside the true surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QualityMm {
    /// Distance from its points to the true surface: mean, median and 95th percentile.
    pub accuracy_mean_mm: f64,
    /// See `accuracy_mean_mm`.
    pub accuracy_median_mm: f64,
    /// See `accuracy_mean_mm`.
    pub accuracy_p95_mm: f64,
    /// Share, 0..=1, of the true surface that is within 1, 2 and 5 mm of it.
    pub completeness_1mm: f64,
    /// See `completeness_1mm`.
    pub completeness_2mm: f64,
    /// See `completeness_1mm`.
    pub completeness_5mm: f64,
    /// Mean distance from the true surface to it.
    pub completeness_mean_mm: f64,
}

impl ScanRecord {
    /// Quality of the final cloud; none where it was not measured.
    pub fn cloud(&self) -> Option<QualityMm> {
        Some(QualityMm {
            accuracy_mean_mm: self.cloud_accuracy_mean_mm?,
            accuracy_median_mm: self.cloud_accuracy_median_mm?,
            accuracy_p95_mm: self.cloud_accuracy_p95_mm?,
            completeness_1mm: self.cloud_completeness_1mm?,
            completeness_2mm: self.cloud_completeness_2mm?,
            completeness_5mm: self.cloud_completeness_5mm?,
            completeness_mean_mm: self.cloud_completeness_mean_mm?,
        })
    }

    /// Quality of the final mesh; none where it was not measured.
    pub fn mesh(&self) -> Option<QualityMm> {
        Some(QualityMm {
            accuracy_mean_mm: self.mesh_accuracy_mean_mm?,
            accuracy_median_mm: self.mesh_accuracy_median_mm?,
            accuracy_p95_mm: self.mesh_accuracy_p95_mm?,
            completeness_1mm: self.mesh_completeness_1mm?,
            completeness_2mm: self.mesh_completeness_2mm?,
            completeness_5mm: self.mesh_completeness_5mm?,
            completeness_mean_mm: self.mesh_completeness_mean_mm?,
        })
    }

    /// Sets the quality of the final cloud.
    pub fn set_cloud(&mut self, quality: Option<QualityMm>) {
        self.cloud_accuracy_mean_mm = quality.map(|q| q.accuracy_mean_mm);
        self.cloud_accuracy_median_mm = quality.map(|q| q.accuracy_median_mm);
        self.cloud_accuracy_p95_mm = quality.map(|q| q.accuracy_p95_mm);
        self.cloud_completeness_1mm = quality.map(|q| q.completeness_1mm);
        self.cloud_completeness_2mm = quality.map(|q| q.completeness_2mm);
        self.cloud_completeness_5mm = quality.map(|q| q.completeness_5mm);
        self.cloud_completeness_mean_mm = quality.map(|q| q.completeness_mean_mm);
    }

    /// Sets the quality of the final mesh.
    pub fn set_mesh(&mut self, quality: Option<QualityMm>) {
        self.mesh_accuracy_mean_mm = quality.map(|q| q.accuracy_mean_mm);
        self.mesh_accuracy_median_mm = quality.map(|q| q.accuracy_median_mm);
        self.mesh_accuracy_p95_mm = quality.map(|q| q.accuracy_p95_mm);
        self.mesh_completeness_1mm = quality.map(|q| q.completeness_1mm);
        self.mesh_completeness_2mm = quality.map(|q| q.completeness_2mm);
        self.mesh_completeness_5mm = quality.map(|q| q.completeness_5mm);
        self.mesh_completeness_mean_mm = quality.map(|q| q.completeness_mean_mm);
    }

    /// Share of the reachable surface seen after each view; none without baselines.
    pub fn reachable_coverage_curve(&self) -> Option<Vec<f64>> {
        self.steps.iter().map(|step| step.reachable_coverage).collect()
    }
}
