use crate::rows_of_pose;
use nextview::motion::{Trajectory, Waypoint};
use nextview::planner::{Explanation, Outlook};
use nextview::session::NextView;
use nextview_robot::path::JointTrajectory;
use serde::{Deserialize, Serialize};

/// A view that is to be taken next, and why: what a robot and a page are told.
///
/// Quantities that are not known are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ViewRecord {
    /// Number among the candidates, from 0; none for a first view that is no candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
    /// Where the camera should stand: the rows of the 4 x 4 matrix that takes points of the camera, which
    /// looks along z with y downwards, to the world; metres.
    pub world_from_camera: [[f64; 4]; 4],
    /// The angle to turn the plate of a turntable to, 0 to 360, counter-clockwise seen from above; none
    /// without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turntable_angle_deg: Option<f64>,
    /// The quantity that the planner maximised, in its unit; none for the first view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// The second best view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runner_up: Option<usize>,
    /// What else the planner says about its choice, with units in the names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// Voxels that this view is expected to add; this and the next three none for planners that do not
    /// estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_new_voxels: Option<f64>,
    /// Voxels that all views together are expected to add.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_unseen_voxels: Option<f64>,
    /// Estimated share, 0..=1, of the surface that can be seen that has been seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_completeness: Option<f64>,
    /// The same after this view and each of those expected to follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forecast_completeness: Option<Vec<f64>>,
    /// Length of the trajectory to this view, around the object and above its table: from the last frame or,
    /// of a view that follows another one, from there.
    pub trajectory_length_m: f64,
    /// Time that a robot would take for it.
    pub trajectory_time_s: f64,
    /// The names of the robot's joints; none without a robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_names: Option<Vec<String>>,
    /// That trajectory.
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
    /// Where the robot's joints are, radians or metres; none without a robot.
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
