use nextview::geometry::{Aabb, Plane, Pose};
use nextview::planner::{Explanation, Outlook};
use nextview::registration::{Registration, Verdict};
use nextview::session::StepReport;
use serde::{Deserialize, Serialize};

/// One view of a scan: a line of `steps.jsonl`, an entry of `steps` of a [`ScanRecord`](super::ScanRecord).
///
/// Unknown quantities are left out. Two equal scans differ only in the entries that end in `_time_ms`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StepRecord {
    /// Number of the step, from 1.
    pub step: usize,
    /// Number of the view among the candidates, from 0; `None` for a first view that is no candidate, or a
    /// frame that was not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
    /// Name of the recorded frame, or the name given by the caller.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Mapped position of the camera in the world in metres: with registration, the corrected one.
    pub position_m: [f64; 3],
    /// Rotation of the camera, world from camera, with the scalar last.
    pub quaternion_xyzw: [f64; 4],

    /// Joint values of the robot, radians or metres; `None` if there is no robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_values: Option<Vec<f64>>,
    /// The angle of a turntable, 0 to 360, counter-clockwise seen from above; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turntable_angle_deg: Option<f64>,

    /// The planner's score of this view, the quantity it maximised; `None` for the first view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// The second best view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runner_up: Option<usize>,
    /// Further quantities that explain the planner's choice, with units in the names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// Voxels seen before this view, in the planner's voxel size; this and the next four are `None` for
    /// planners without estimates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planner_seen_voxels: Option<usize>,
    /// Number of voxels that this view was expected to add.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_new_voxels: Option<f64>,
    /// Number of voxels that all views together were expected to add.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_unseen_voxels: Option<f64>,
    /// Estimated share, 0..=1, of the visible surface seen before this view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_completeness: Option<f64>,
    /// Estimated completeness after this view and each expected later view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forecast_completeness: Option<Vec<f64>>,

    /// Edge of the voxels used to plan the view.
    pub voxel_size_m: f64,
    /// Lowest and highest corners of the object's box after the frame; `None` before an object was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_min_m: Option<[f64; 3]>,
    /// See `box_min_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_max_m: Option<[f64; 3]>,
    /// The table: unit normal `n` and offset `d` of the plane `n . p = d`; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_normal: Option<[f64; 3]>,
    /// See `table_normal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_offset_m: Option<f64>,

    /// Voxels that the frame hit.
    pub hit_voxels: usize,
    /// Voxels that its rays passed through.
    pub missed_voxels: usize,
    /// Voxels that it measured for the first time.
    pub first_measured_voxels: usize,
    /// Voxels that became occupied.
    pub new_voxels: usize,
    /// Occupied voxels in the box after the frame.
    pub occupied_voxels: usize,
    /// Free voxels in the box.
    pub free_voxels: usize,
    /// Voxels in the box that were never measured.
    pub unknown_voxels: usize,
    /// Entropy of the box: the paper's eq. (8).
    pub entropy_nats: f64,
    /// The entropy as a share, 0..=1, of that of an unknown box.
    pub entropy_share: f64,

    /// Share, 0..=1, of the voxels with measured surface that meet the accuracy goal and have all looks;
    /// `None` if there are no such goals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_at_goal: Option<f64>,

    /// Whether the frame was aligned; this and the next nine are `None` if registration is off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_accepted: Option<bool>,
    /// `aligned`, or why the given pose was kept, in part (`sliding`) or entirely.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_verdict: Option<Verdict>,
    /// Root mean square distance of the frame's points from the known surface in the given pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_residual_before_mm: Option<f64>,
    /// Root mean square distance in the aligned pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_residual_after_mm: Option<f64>,
    /// Share, 0..=1, of the frame's points on the known surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_overlap: Option<f64>,
    /// Distance by which the alignment moves the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_moved_mm: Option<f64>,
    /// Angle by which the alignment turns the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_turned_deg: Option<f64>,
    /// How well the surface constrains the frame's pose, 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_stiffness: Option<f64>,
    /// Iterations of the alignment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_n_iterations: Option<usize>,
    /// Whether the frame was set aside: it is not in the map, unless a later step recovers it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_set_aside: Option<bool>,
    /// Numbers of earlier steps whose frames had been set aside and were added to the map in this step.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub registration_recovered_steps: Vec<usize>,

    /// Occupied object voxels of the map over object voxels, 0..=1; this and all following measures before
    /// the path are `None` if the true object is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxel_coverage: Option<f64>,
    /// Occupied voxels that are not object voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_voxels: Option<usize>,
    /// Share, 0..=1, of the occupied voxels that are object voxels; `None` if no voxel is occupied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_precision: Option<f64>,
    /// Share, 0..=1, of the reachable object voxels that are occupied; this and the next are `None` if there
    /// are no baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_recall: Option<f64>,
    /// Occupied reachable object voxels over the sum of all reachable object voxels and `false_voxels`,
    /// 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_iou: Option<f64>,
    /// Share, 0..=1, of the reachable surface that was seen: object voxels truly seen over those that any
    /// candidate sees; `None` if there are no baselines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reachable_coverage: Option<f64>,
    /// Share, 0..=1, of the true surface with a measured point within 1 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_coverage_1mm: Option<f64>,
    /// As `surface_coverage_1mm`, but within 2 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_coverage_2mm: Option<f64>,
    /// As `surface_coverage_1mm`, but within 5 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_coverage_5mm: Option<f64>,
    /// Root mean square displacement of the object's points due to the error of the mapped pose; `None` if
    /// poses are right or the true ones unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub misplaced_mm: Option<f64>,
    /// Why the frames probably show nothing of the object or do not fit together, and a remedy; configuration
    /// keys are in backticks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warning: Option<String>,
    /// Mean distance from all points measured so far to the true surface; this and the next two are for
    /// recordings only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_mean_mm: Option<f64>,
    /// Median of these distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_median_mm: Option<f64>,
    /// 95th percentile of these distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_p95_mm: Option<f64>,

    /// Length of the straight path through the mapped positions of all frames so far: the measured poses, not
    /// the requested ones.
    pub path_length_m: f64,
    /// Length of the trajectory so far, around the object and above its table.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for the trajectory.
    pub trajectory_time_s: f64,
    /// Time to choose this view.
    pub plan_time_ms: f64,
    /// Time to integrate its frame into the map.
    pub map_time_ms: f64,
    /// Time from the request to the frame: to render, load or take it.
    pub capture_time_ms: f64,
}

impl StepRecord {
    /// The session's part: everything except measures against the truth, lengths and times.
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

    /// The mapped pose of the camera.
    pub fn world_from_camera(&self) -> Option<Pose> {
        Pose::new(glam::DQuat::from_array(self.quaternion_xyzw), self.position_m.into()).ok()
    }

    /// The object's box after the frame.
    pub fn bounds(&self) -> Option<Aabb> {
        Some(Aabb { min: self.box_min_m?.into(), max: self.box_max_m?.into() })
    }

    /// The object's table.
    pub fn table(&self) -> Option<Plane> {
        let normal = glam::DVec3::from_array(self.table_normal?);
        Plane::new(normal, normal * self.table_offset_m?).ok()
    }
}
