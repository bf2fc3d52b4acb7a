use super::{PlacementRecord, StepRecord, TurnRecord};
use crate::{BoxRule, PlannerChoice, Profile};
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
    pub planner: PlannerChoice,
    /// The named set of defaults that the configuration came from.
    pub profile: Profile,
    /// Seed of the planners random and receding-horizon.
    pub seed: u64,
    /// Seed of the random shell; none where no random shell makes the candidates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seed: Option<u64>,
    /// Seed of the errors of depths and poses; none where the camera is exact or real.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_seed: Option<u64>,
    /// Seed of the random views of `random_curve`; none without baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline_seed: Option<u64>,
    /// Why the scan ended; none while it is under way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_reason: Option<StopReason>,
    /// Edge of the finest voxels.
    pub voxel_size_m: f64,
    /// Number of view candidates.
    pub candidates: usize,
    /// Number of views taken: that of `steps`.
    pub views: usize,
    /// Number of views whose frames registration set aside for good: they are in neither map nor model. None
    /// without registration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_set_aside: Option<usize>,
    /// How the object was turned since the scan before; none without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<TurnRecord>,
    /// How to lay the object down, so that what cannot be seen as it lies can be seen then; none without a
    /// table, and where hardly anything would be freed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_placement: Option<PlacementRecord>,

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

    /// Mean of `reachable_coverage` over the views that the scan could take, 0..=1; after an early end, the
    /// last value stays. This and the next two none without baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_auc_views: Option<f64>,
    /// Mean of `reachable_coverage` over the time of a robot, moving and sensing, up to
    /// `coverage_auc_horizon_s`, 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_auc_time: Option<f64>,
    /// The end of that time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_auc_horizon_s: Option<f64>,

    /// Whether the box around the object was known or grew; this and the next two none without a
    /// configuration that says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_rule: Option<BoxRule>,
    /// Side of the box over the object's longest side, without the next; none where the box was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_margin_factor: Option<f64>,
    /// Voxels by which the box is wider on each side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_margin_voxels: Option<f64>,
    /// Lowest and highest corner of the box at the end; none if no object was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_min_m: Option<[f64; 3]>,
    /// See `box_min_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_max_m: Option<[f64; 3]>,

    /// Length of the straight path through the positions of all views.
    pub path_length_m: f64,
    /// Length of the trajectory around the object and above its table.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for it.
    pub trajectory_time_s: f64,

    /// Rigid motion by which the model was moved before it was measured, true world from mapped world: the
    /// translation. The identity where the first pose is right; this and the next three none where no model
    /// was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_translation_m: Option<[f64; 3]>,
    /// Its rotation, scalar last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_quaternion_xyzw: Option<[f64; 4]>,
    /// How far it moves the middle of the true object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_moved_mm: Option<f64>,
    /// The angle that it turns by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_turned_deg: Option<f64>,
    /// Mean distance from the points of the final cloud to the true surface; this and what follows of the
    /// cloud none where the truth is not known or the cloud holds nothing of the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_accuracy_mean_mm: Option<f64>,
    /// Median of these distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_accuracy_median_mm: Option<f64>,
    /// 95th percentile of these distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_accuracy_p95_mm: Option<f64>,
    /// Share, 0..=1, of the points of the cloud within 1 mm of the true surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_precision_1mm: Option<f64>,
    /// The same within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_precision_2mm: Option<f64>,
    /// The same within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_precision_5mm: Option<f64>,
    /// Share, 0..=1, of the true surface, all of it, with a point of the cloud within 1 mm.
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
    /// Share, 0..=1, of the reachable surface with a point of the cloud within 1 mm; this and what follows of
    /// the cloud none without baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_recall_1mm: Option<f64>,
    /// The same within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_recall_2mm: Option<f64>,
    /// The same within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_recall_5mm: Option<f64>,
    /// Mean distance from the reachable surface to the cloud.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_reachable_completeness_mean_mm: Option<f64>,
    /// Harmonic mean of precision and recall at 1 mm, 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_f_score_1mm: Option<f64>,
    /// The same at 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_f_score_2mm: Option<f64>,
    /// The same at 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_f_score_5mm: Option<f64>,
    /// Chamfer distance: mean of `cloud_accuracy_mean_mm` and `cloud_reachable_completeness_mean_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_chamfer_mm: Option<f64>,
    /// The same of the final mesh, whose points are its vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_accuracy_mean_mm: Option<f64>,
    /// See `cloud_accuracy_median_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_accuracy_median_mm: Option<f64>,
    /// See `cloud_accuracy_p95_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_accuracy_p95_mm: Option<f64>,
    /// See `cloud_precision_1mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_precision_1mm: Option<f64>,
    /// See `cloud_precision_2mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_precision_2mm: Option<f64>,
    /// See `cloud_precision_5mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_precision_5mm: Option<f64>,
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
    /// See `cloud_recall_1mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_recall_1mm: Option<f64>,
    /// See `cloud_recall_2mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_recall_2mm: Option<f64>,
    /// See `cloud_recall_5mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_recall_5mm: Option<f64>,
    /// See `cloud_reachable_completeness_mean_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_reachable_completeness_mean_mm: Option<f64>,
    /// See `cloud_f_score_1mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_f_score_1mm: Option<f64>,
    /// See `cloud_f_score_2mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_f_score_2mm: Option<f64>,
    /// See `cloud_f_score_5mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_f_score_5mm: Option<f64>,
    /// See `cloud_chamfer_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_chamfer_mm: Option<f64>,
    /// Share, 0..=1, of the mesh's area that was filled in, where nothing was measured; all other measures
    /// are of the measured part. None of a mesh that is left open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_filled_share: Option<f64>,

    /// Median over the points of the cloud of their expected error along the normal, a standard deviation
    /// that follows from the camera's; none where that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_expected_error_median_mm: Option<f64>,
    /// The 95th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_expected_error_p95_mm: Option<f64>,

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

impl ScanRecord {
    /// The steps whose frames registration set aside for good.
    pub fn steps_set_aside(&self) -> impl Iterator<Item = &StepRecord> {
        let is_recovered =
            |step: usize| self.steps.iter().any(|s| s.registration_recovered_steps.contains(&step));
        self.steps
            .iter()
            .filter(move |step| step.registration_set_aside == Some(true) && !is_recovered(step.step))
    }

    /// Share of the reachable surface seen after each view; none without baselines.
    pub fn reachable_coverage_curve(&self) -> Option<Vec<f64>> {
        self.steps.iter().map(|step| step.reachable_coverage).collect()
    }
}
