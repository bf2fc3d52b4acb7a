use crate::rows_of_pose;
use nextview::motion::{Trajectory, Waypoint};
use nextview::planner::{Explanation, Outlook};
use nextview::session::NextView;
use nextview_robot::path::JointTrajectory;
use serde::{Deserialize, Serialize};

/// The next view and the reasons for it, for a robot and a page.
///
/// Unknown quantities are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ViewRecord {
    /// Number among the candidates, from 0; `None` for a first view that is no candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
    /// Pose of the camera: the rows of the 4 x 4 matrix that takes points from camera to world in metres. The
    /// camera looks along z, with y downwards.
    pub world_from_camera: [[f64; 4]; 4],
    /// The turntable angle for the view, 0 to 360, counter-clockwise seen from above; `None` if there is no
    /// turntable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turntable_angle_deg: Option<f64>,
    /// The planner's score, the quantity it maximised, in its unit; `None` for the first view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// The second best view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runner_up: Option<usize>,
    /// Further quantities that explain the planner's choice, with units in the names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// Number of voxels that this view is expected to add; this and the next three are `None` for planners
    /// without estimates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_new_voxels: Option<f64>,
    /// Number of voxels that all views together are expected to add.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_unseen_voxels: Option<f64>,
    /// Estimated share, 0..=1, of the visible surface seen so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_completeness: Option<f64>,
    /// Estimated completeness after this view and each expected later view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forecast_completeness: Option<Vec<f64>>,
    /// Length of the trajectory to this view, around the object and above its table: from the last frame, or
    /// from the preceding view of a sequence.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for the trajectory.
    pub trajectory_time_s: f64,
    /// Names of the robot's joints; `None` if there is no robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_names: Option<Vec<String>>,
    /// The waypoints of the trajectory.
    pub waypoints: Vec<WaypointRecord>,
}

/// A pose on the way to a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WaypointRecord {
    /// Time since the camera set off.
    pub time_s: f64,
    /// Position of the camera in the world, metres.
    pub position_m: [f64; 3],
    /// Rotation of the camera, world from camera, with the scalar last.
    pub quaternion_xyzw: [f64; 4],
    /// Joint values of the robot, radians or metres; `None` if there is no robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_values: Option<Vec<f64>>,
}

impl ViewRecord {
    /// The record of a view and of the trajectory to it.
    pub(crate) fn new(next: &NextView, trajectory: &Trajectory, joints: Option<&JointTrajectory>) -> Self {
        let (choice, outlook) = (next.choice.as_ref(), next.outlook.as_ref());
        let waypoint = |Waypoint { time, world_from_camera }: &Waypoint| WaypointRecord {
            time_s: *time,
            position_m: world_from_camera.translation().to_array(),
            quaternion_xyzw: world_from_camera.rotation().to_array(),
            joint_values: None,
        };
        let mut waypoints: Vec<WaypointRecord> = trajectory.waypoints().iter().map(waypoint).collect();
        for (waypoint, (_, values)) in
            waypoints.iter_mut().zip(joints.iter().flat_map(|joints| &joints.points))
        {
            waypoint.joint_values = Some(values.clone());
        }
        Self {
            view: next.view,
            world_from_camera: rows_of_pose(&next.world_from_camera),
            turntable_angle_deg: None,
            score: choice.map(|choice| choice.score),
            runner_up: choice.and_then(|choice| choice.runner_up),
            explanation: choice.and_then(|choice| choice.explanation.clone()),
            expected_new_voxels: outlook.map(Outlook::n_expected_next),
            expected_unseen_voxels: outlook.map(|outlook| outlook.n_unseen),
            estimated_completeness: outlook.map(Outlook::completeness),
            forecast_completeness: outlook.map(Outlook::forecast),
            trajectory_length_m: trajectory.length(),
            trajectory_time_s: trajectory.duration(),
            joint_names: joints.map(|joints| joints.names.clone()),
            waypoints,
        }
    }
}
