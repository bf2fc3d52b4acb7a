use nextview::geometry::{Aabb, Plane, Pose};
use nextview::planner::{Explanation, Outlook};
use nextview::registration::{Registration, Verdict};
use nextview::session::StepReport;
use serde::{Deserialize, Serialize};

/// Everything about one view of a scan: a line of `steps.jsonl`, an entry of `steps` of a
/// [`ScanRecord`](super::ScanRecord).
///
/// Quantities that are not known are left out. Two equal scans differ in the entries that end in `_time_ms`
/// only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StepRecord {
    /// Number of the step, from 1.
    pub step: usize,
    /// Number of the view among the candidates, from 0; none for a first view that is no candidate, or a
    /// frame that was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
    /// Name of the recorded frame, or that which whoever took it gave it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Position of the camera in the world, metres, as the map has it: with registration, the corrected one.
    pub position_m: [f64; 3],
    /// Rotation of the camera, world from camera, with the scalar last.
    pub quaternion_xyzw: [f64; 4],

    /// Where the robot's joints are, radians or metres; none without a robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_values: Option<Vec<f64>>,
    /// The angle of a turntable, 0 to 360, counter-clockwise seen from above; none without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turntable_angle_deg: Option<f64>,

    /// The quantity that the planner maximised, of this view; none for the first one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// The second best view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runner_up: Option<usize>,
    /// What else the planner says about its choice, with units in the names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// Voxels seen before this view, of the size that the planner thinks in; this and the next four none for
    /// planners that do not estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planner_seen_voxels: Option<usize>,
    /// Voxels that this view was expected to add to them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_new_voxels: Option<f64>,
    /// Voxels that all views together were expected to add.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_unseen_voxels: Option<f64>,
    /// Estimated share, 0..=1, of the surface that can be seen that had been seen before this view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_completeness: Option<f64>,
    /// The same after this view and each of those expected to follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forecast_completeness: Option<Vec<f64>>,

    /// Edge of the voxels in which the view was planned.
    pub voxel_size_m: f64,
    /// Lowest and highest corner of the box around the object after the frame; none before an object was
    /// found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_min_m: Option<[f64; 3]>,
    /// See `box_min_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_max_m: Option<[f64; 3]>,
    /// The table: unit normal `n` and offset `d` of the plane `n . p = d`; none without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_normal: Option<[f64; 3]>,
    /// See `table_normal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_offset_m: Option<f64>,

    /// Voxels that the frame hit.
    pub hit_voxels: usize,
    /// Voxels that its rays passed.
    pub missed_voxels: usize,
    /// Voxels that it measured for the first time.
    pub first_measured_voxels: usize,
    /// Voxels that became occupied.
    pub new_voxels: usize,
    /// Occupied voxels of the box after the frame.
    pub occupied_voxels: usize,
    /// Free voxels of the box.
    pub free_voxels: usize,
    /// Voxels of the box that were never measured.
    pub unknown_voxels: usize,
    /// Entropy of the box: the paper's eq. (8).
    pub entropy_nats: f64,
    /// The same as a share, 0..=1, of that of an unknown box.
    pub entropy_share: f64,

    /// Share, 0..=1, of the voxels with measured surface whose expected error is within the goal, and that
    /// have all looks; none without such goals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_at_goal: Option<f64>,

    /// Whether the frame was aligned; this and the next nine none without registration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_accepted: Option<bool>,
    /// `aligned`, or why the given pose stayed, in part (`sliding`) or at all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_verdict: Option<Verdict>,
    /// Root mean square distance of the frame's points from the known surface, in the given pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_residual_before_mm: Option<f64>,
    /// The same in the aligned pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_residual_after_mm: Option<f64>,
    /// Share, 0..=1, of the frame's points on the known surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_overlap: Option<f64>,
    /// How far the alignment moves the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_moved_mm: Option<f64>,
    /// How far it turns the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_turned_deg: Option<f64>,
    /// How well the surface holds the frame in place, 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_stiffness: Option<f64>,
    /// Iterations of the alignment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_n_iterations: Option<usize>,
    /// Whether the frame was set aside: it is not in the map, unless a later step recovers it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_set_aside: Option<bool>,
    /// Numbers of the steps whose frames had been set aside and came into the map with this one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub registration_recovered_steps: Vec<usize>,

    /// Occupied object voxels of the map over object voxels, 0..=1; this and what follows up to the path none
    /// where the true object is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxel_coverage: Option<f64>,
    /// Occupied voxels that are no object voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_voxels: Option<usize>,
    /// Share, 0..=1, of the occupied voxels that are object voxels; none if no voxel is occupied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_precision: Option<f64>,
    /// Share, 0..=1, of the reachable object voxels that are occupied; this and the next none without
    /// baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_recall: Option<f64>,
    /// Occupied reachable object voxels over the sum of all reachable object voxels and `false_voxels`,
    /// 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_iou: Option<f64>,
    /// Share, 0..=1, of the reachable surface that was seen: object voxels truly seen over those that any
    /// candidate sees; none without baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_coverage: Option<f64>,
    /// Share, 0..=1, of the true surface with a measured point within 1 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_coverage_1mm: Option<f64>,
    /// The same within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_coverage_2mm: Option<f64>,
    /// The same within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_coverage_5mm: Option<f64>,
    /// Root mean square distance of the object's points from where they are, for the pose in which the frame
    /// was mapped; none where poses are right or the true ones are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub misplaced_mm: Option<f64>,
    /// Why the frames probably show nothing of the object, or do not fit together, and what to do about it;
    /// keys of the configuration stand in backticks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warning: Option<String>,
    /// Mean distance from all points measured so far to the true surface; this and the next two of recordings
    /// only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_mean_mm: Option<f64>,
    /// Median of the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_median_mm: Option<f64>,
    /// 95th percentile of the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_p95_mm: Option<f64>,

    /// Length of the straight path through the positions of all frames so far, as they are mapped: where the
    /// poses are measured, not where the views were asked for.
    pub path_length_m: f64,
    /// Length of the trajectory so far, around the object and above its table.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for it.
    pub trajectory_time_s: f64,
    /// Time to choose this view.
    pub plan_time_ms: f64,
    /// Time to write its frame into the map.
    pub map_time_ms: f64,
    /// Time from asking for the frame until it came: to render it, to load it, or to take it.
    pub capture_time_ms: f64,
}

impl StepRecord {
    /// The session's part: everything but what is known of the truth, lengths and times.
    pub(crate) fn of_report(step: usize, report: &StepReport) -> Self {
        let choice = report.choice.as_ref();
        let outlook = report.outlook.as_ref();
        let mut record = Self {
            step,
            view: report.view,
            score: choice.map(|choice| choice.score),
            runner_up: choice.and_then(|choice| choice.runner_up),
            explanation: choice.and_then(|choice| choice.explanation.clone()),
            planner_seen_voxels: outlook.map(|outlook| outlook.n_seen),
            expected_new_voxels: outlook.map(Outlook::n_expected_next),
            expected_unseen_voxels: outlook.map(|outlook| outlook.n_unseen),
            estimated_completeness: outlook.map(Outlook::completeness),
            forecast_completeness: outlook.map(Outlook::forecast),
            voxel_size_m: report.voxel_size,
            box_min_m: report.bounds.map(|bounds| bounds.min.to_array()),
            box_max_m: report.bounds.map(|bounds| bounds.max.to_array()),
            table_normal: report.table.map(|table| table.normal().to_array()),
            table_offset_m: report.table.map(|table| table.offset()),
            hit_voxels: report.update.n_hits,
            missed_voxels: report.update.n_misses,
            first_measured_voxels: report.update.n_first_measured,
            new_voxels: report.update.n_newly_occupied,
            occupied_voxels: report.map.n_occupied,
            free_voxels: report.map.n_free,
            unknown_voxels: report.map.n_unknown,
            entropy_nats: report.map.entropy,
            entropy_share: report.map.entropy_share,
            share_at_goal: report.share_at_goal,
            ..Self::default()
        };
        record.set_pose(&report.world_from_camera);
        report.registration.iter().for_each(|found| record.set_registration(found));
        record.registration_set_aside = report.registration.map(|_| report.is_set_aside);
        record.registration_recovered_steps = report.recovered.iter().map(|number| number + 1).collect();
        record
    }

    fn set_pose(&mut self, world_from_camera: &Pose) {
        self.position_m = world_from_camera.translation().to_array();
        self.quaternion_xyzw = world_from_camera.rotation().to_array();
    }

    fn set_registration(&mut self, found: &Registration) {
        self.registration_accepted = Some(found.is_accepted());
        self.registration_verdict = Some(found.verdict);
        self.registration_residual_before_mm = Some(1e3 * found.residual_before);
        self.registration_residual_after_mm = Some(1e3 * found.residual_after);
        self.registration_overlap = Some(found.overlap);
        self.registration_moved_mm = Some(1e3 * found.moved);
        self.registration_turned_deg = Some(found.turned.to_degrees());
        self.registration_stiffness = Some(found.stiffness);
        self.registration_n_iterations = Some(found.n_iterations);
    }

    /// Sets the measures of the map.
    #[cfg(feature = "simulated")]
    pub(crate) fn set_voxels(&mut self, score: &nextview_sim::truth::VoxelScore) {
        self.voxel_coverage = Some(score.coverage());
        self.false_voxels = Some(score.n_false);
        self.map_precision = score.precision();
        self.map_recall = score.recall();
        self.map_iou = score.iou();
    }

    /// The pose of the camera as the map has it.
    pub fn world_from_camera(&self) -> Option<Pose> {
        Pose::new(glam::DQuat::from_array(self.quaternion_xyzw), self.position_m.into()).ok()
    }

    /// The box around the object after the frame.
    pub fn bounds(&self) -> Option<Aabb> {
        Some(Aabb { min: self.box_min_m?.into(), max: self.box_max_m?.into() })
    }

    /// The table that the object stands on.
    pub fn table(&self) -> Option<Plane> {
        let normal = glam::DVec3::from_array(self.table_normal?);
        Plane::new(normal, normal * self.table_offset_m?).ok()
    }
}
