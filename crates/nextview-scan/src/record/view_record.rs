use crate::rows_of_pose;
use nextview::motion::Trajectory;
use nextview::planner::Explanation;
use nextview::session::NextView;
use serde::{Deserialize, Serialize};

/// The view to take next: where, why, and how to get there. Quantities that are not known are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ViewRecord {
    /// Number among the candidates, from 0; none for a first view that is no candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
    /// Pose of the camera, the rows of a 4 x 4 matrix, metres; the camera looks along z, and y points down.
    pub world_from_camera: [[f64; 4]; 4],
    /// The quantity that the planner maximised; none for the first view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// Number of the second best view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runner_up: Option<usize>,
    /// What else the planner says about its choice, with units in the names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// Voxels that this view is expected to add; this and the next two none for planners that do not
    /// estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_new_voxels: Option<f64>,
    /// Voxels that all views together are expected to add.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_unseen_voxels: Option<f64>,
    /// Estimated share, 0..=1, of the visible surface seen before this view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_completeness: Option<f64>,
    /// The trajectory from the last frame to this view, around the object.
    pub waypoints: Vec<WaypointRecord>,
    /// Its length.
    pub trajectory_length_m: f64,
}

/// A pose on the way to a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WaypointRecord {
    /// Time since the camera set off.
    pub time_s: f64,
    /// Pose of the camera, the rows of a 4 x 4 matrix, metres.
    pub world_from_camera: [[f64; 4]; 4],
}

impl ViewRecord {
    /// The record of a view and of the trajectory to it.
    pub fn new(next: &NextView, trajectory: &Trajectory) -> Self {
        let (choice, outlook) = (next.choice.as_ref(), next.outlook);
        Self {
            view: next.view,
            world_from_camera: rows_of_pose(&next.world_from_camera),
            score: choice.map(|choice| choice.score),
            runner_up: choice.and_then(|choice| choice.runner_up),
            explanation: choice.and_then(|choice| choice.explanation.clone()),
            expected_new_voxels: outlook.map(|outlook| outlook.n_expected),
            expected_unseen_voxels: outlook.map(|outlook| outlook.n_unseen),
            estimated_completeness: outlook.map(|outlook| outlook.completeness()),
            waypoints: trajectory
                .waypoints()
                .iter()
                .map(|point| WaypointRecord {
                    time_s: point.time,
                    world_from_camera: rows_of_pose(&point.world_from_camera),
                })
                .collect(),
            trajectory_length_m: trajectory.length(),
        }
    }
}
