use super::{HandEyeRecord, PlacementRecord, StepRecord, TurnRecord};
use crate::{BoxRule, PlannerChoice, Profile};
use nextview::object::OtherBody;
use nextview::session::StopReason;
use serde::{Deserialize, Serialize};

/// A scan, finished or in progress: `record.json`, and the output of `nextview scan --json`.
///
/// Unknown quantities are left out. Two equal scans differ only in `peak_memory_mb` and in the entries that
/// end in `_time_ms`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ScanRecord {
    /// Name of the object: of its file without extension, or of the built-in object.
    pub object: String,
    /// The planner.
    pub planner: PlannerChoice,
    /// The profile of the configuration.
    pub profile: Profile,
    /// Seed of the planners random and receding-horizon.
    pub seed: u64,
    /// Seed of the random shell; `None` if no random shell generates the candidates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seed: Option<u64>,
    /// Seed of the errors of depths and poses; `None` if the camera is exact or real.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_seed: Option<u64>,
    /// Seed of the random views of `random_curve`; `None` if there are no baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline_seed: Option<u64>,
    /// Why the scan ended; `None` while it is in progress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_reason: Option<StopReason>,
    /// Edge of the finest voxels.
    pub voxel_size_m: f64,
    /// Number of view candidates.
    pub candidates: usize,
    /// Number of views taken: the length of `steps`.
    pub views: usize,
    /// Number of views with frames that registration set aside for good: they are in neither map nor model.
    /// `None` if registration is off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_set_aside: Option<usize>,
    /// Root mean square distance between the surfaces that different frames show, all aligned; this and the
    /// next two are `None` if frames are not aligned to each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame_residual_mm: Option<f64>,
    /// By entry of `steps`, root mean square distance of the frame's surface from those of the others; null
    /// for frames that meet no other, and for those set aside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame_residuals_mm: Option<Vec<Option<f64>>>,
    /// The error that all given poses share; also `None` if the poses come from alignment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand_eye: Option<HandEyeRecord>,
    /// How the object was turned since the previous scan; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<TurnRecord>,
    /// The placement that exposes most of the hidden surface; `None` if there is no table, or if it exposes
    /// hardly anything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_placement: Option<PlacementRecord>,

    /// Voxels that contain some of the true surface; `None` if the true object is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object_voxels: Option<usize>,
    /// Object voxels that any candidate sees; this and the next four are `None` if there are no baselines.
    /// For a recording with known truth: surface samples that any frame shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_voxels: Option<usize>,
    /// Share, 0..=1, of the reachable surface seen at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_coverage: Option<f64>,
    /// `reachable_coverage` after each view for random views: mean of many sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_curve: Option<Vec<f64>>,
    /// 5th percentile of the random sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_low_curve: Option<Vec<f64>>,
    /// 95th percentile of the random sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_high_curve: Option<Vec<f64>>,
    /// `reachable_coverage` after each view for the planner that knows the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clairvoyant_curve: Option<Vec<f64>>,
    /// Area under the curve of `reachable_coverage`, on the scale from random views (0) to the clairvoyant
    /// planner (1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skill: Option<f64>,

    /// Mean of `reachable_coverage` over the maximum number of views, 0..=1; after an early end, the last
    /// value stays. This and the next two are `None` if there are no baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_auc_views: Option<f64>,
    /// Mean of `reachable_coverage` over a robot's moving and sensing time up to `coverage_auc_horizon_s`,
    /// 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_auc_time: Option<f64>,
    /// The moving and sensing time over which `coverage_auc_time` is the mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_auc_horizon_s: Option<f64>,

    /// Whether the object's box was known or grew; this and the next two are `None` if no configuration
    /// states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_rule: Option<BoxRule>,
    /// Side of the box relative to the object's longest side, without `box_margin_voxels`; `None` if the box
    /// was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_margin_factor: Option<f64>,
    /// Additional margin of the box on each side in voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_margin_voxels: Option<f64>,
    /// Lowest and highest corners of the box at the end; `None` if no object was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_min_m: Option<[f64; 3]>,
    /// See `box_min_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_max_m: Option<[f64; 3]>,

    /// Length of the straight path through the positions of all views.
    pub path_length_m: f64,
    /// Length of the trajectory around the object and above its table.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for the trajectory.
    pub trajectory_time_s: f64,

    /// Rigid motion of the model before measuring, true world from mapped world: the translation. The
    /// identity if the first pose is right; this and the next three are `None` if no model was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_translation_m: Option<[f64; 3]>,
    /// Rotation of the alignment, scalar last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_quaternion_xyzw: Option<[f64; 4]>,
    /// Distance by which the alignment moves the middle of the true object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_moved_mm: Option<f64>,
    /// Angle of the alignment's rotation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_turned_deg: Option<f64>,
    /// Mean distance from the points of the final cloud to the true surface; this and the following cloud
    /// entries are `None` if the truth is unknown or the cloud contains nothing of the object.
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
    /// As `cloud_precision_1mm`, but within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_precision_2mm: Option<f64>,
    /// As `cloud_precision_1mm`, but within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_precision_5mm: Option<f64>,
    /// Share, 0..=1, of the whole true surface with a point of the cloud within 1 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_1mm: Option<f64>,
    /// As `cloud_completeness_1mm`, but within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_2mm: Option<f64>,
    /// As `cloud_completeness_1mm`, but within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_5mm: Option<f64>,
    /// Mean distance from the true surface to the cloud.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_completeness_mean_mm: Option<f64>,
    /// Share, 0..=1, of the reachable surface with a point of the cloud within 1 mm; this and the following
    /// cloud entries are `None` if there are no baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_recall_1mm: Option<f64>,
    /// As `cloud_recall_1mm`, but within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_recall_2mm: Option<f64>,
    /// As `cloud_recall_1mm`, but within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_recall_5mm: Option<f64>,
    /// Mean distance from the reachable surface to the cloud.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_reachable_completeness_mean_mm: Option<f64>,
    /// Harmonic mean of precision and recall at 1 mm, 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_f_score_1mm: Option<f64>,
    /// As `cloud_f_score_1mm`, but at 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_f_score_2mm: Option<f64>,
    /// As `cloud_f_score_1mm`, but at 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_f_score_5mm: Option<f64>,
    /// Chamfer distance: mean of `cloud_accuracy_mean_mm` and `cloud_reachable_completeness_mean_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_chamfer_mm: Option<f64>,
    /// As `cloud_accuracy_mean_mm`, but for the final mesh; its vertices are the points.
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
    /// Share, 0..=1, of the mesh's area that was filled in where nothing was measured; all other measures are
    /// of the measured part. `None` for an open mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_filled_share: Option<f64>,

    /// Median expected error of the cloud's points along the normal: a standard deviation derived from the
    /// camera's error. `None` if that is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_expected_error_median_mm: Option<f64>,
    /// 95th percentile of the expected errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cloud_expected_error_p95_mm: Option<f64>,

    /// Frames and poses left out of the recording, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub skipped: Vec<String>,
    /// Bodies near the object that do not belong to it, nearest first, if the box grows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub other_bodies: Vec<OtherBodyRecord>,
    /// Other oddities of the recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Time to compute the baselines, excluded from the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline_time_ms: Option<f64>,
    /// Peak memory of the process; `None` if the system does not report it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_memory_mb: Option<f64>,

    /// The views in the order in which they were taken.
    pub steps: Vec<StepRecord>,
}

/// A body seen near the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OtherBodyRecord {
    /// Middle of the box around its measured points, in the world.
    pub center_m: [f64; 3],
    /// Size of that box.
    pub size_m: [f64; 3],
    /// Distance from the object: with a larger `object_box.max_gap_m`, it belongs to the object.
    pub gap_m: f64,
}

impl From<OtherBody> for OtherBodyRecord {
    fn from(OtherBody { bounds, gap }: OtherBody) -> Self {
        Self { center_m: bounds.center().to_array(), size_m: bounds.size().to_array(), gap_m: gap }
    }
}

impl ScanRecord {
    /// The steps with frames that registration set aside for good.
    pub fn steps_set_aside(&self) -> impl Iterator<Item = &StepRecord> {
        let is_recovered =
            |step: usize| self.steps.iter().any(|s| s.registration_recovered_steps.contains(&step));
        self.steps
            .iter()
            .filter(move |step| step.registration_set_aside == Some(true) && !is_recovered(step.step))
    }

    /// Share of the reachable surface seen after each view; `None` if there are no baselines.
    pub fn reachable_coverage_curve(&self) -> Option<Vec<f64>> {
        self.steps.iter().map(|step| step.reachable_coverage).collect()
    }
}
