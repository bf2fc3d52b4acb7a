//! The next view.

use crate::errors::{input_error, internal_error};
use crate::pose::{matrix, pose_of_matrix, poses};
use crate::records::to_python;
use nextview::geometry::Pose;
use nextview::motion::{Trajectory, Waypoint};
use nextview::planner::{Choice, Outlook};
use nextview::session::NextView;
use nextview_robot::path::JointTrajectory;
use numpy::{PyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// The next pose of the camera, and the reasons for it.
#[pyclass(frozen, module = "nextview._native")]
pub struct View {
    next: NextView,
    waypoints: Vec<(f64, Pose)>,
    trajectory_length: f64,
    /// For a robot: names, and the values at each waypoint.
    joints: Option<Joints>,
    turntable_angle_deg: Option<f64>,
}

/// Names of joints, and their values at each waypoint.
type Joints = (Vec<String>, Vec<Vec<f64>>);

/// A view in pickled form.
#[derive(Serialize, Deserialize)]
struct Pickled {
    view: Option<usize>,
    world_from_camera: Pose,
    choice: Option<Choice>,
    outlook: Option<Outlook>,
    waypoints: Vec<(f64, Pose)>,
    trajectory_length: f64,
    /// For a robot: names, and the values at each waypoint.
    joints: Option<Joints>,
    turntable_angle_deg: Option<f64>,
}

/// Restores a view from its pickled text.
#[pyfunction]
pub fn view_of_text(py: Python<'_>, text: &str) -> PyResult<View> {
    let Pickled {
        view,
        world_from_camera,
        choice,
        outlook,
        waypoints,
        trajectory_length,
        joints,
        turntable_angle_deg,
    } = serde_json::from_str(text)
        .map_err(|error| input_error(py, format!("this is not a pickled view: {error}")))?;
    let next = NextView { view, world_from_camera, choice, outlook };
    Ok(View { next, waypoints, trajectory_length, joints, turntable_angle_deg })
}

/// The pose of a view, or of a 4 x 4 matrix that takes points from camera to world. A view's matrix loses the
/// last bits of its pose, unlike the view itself.
pub fn pose_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Pose> {
    match value.cast::<View>() {
        Ok(view) => Ok(view.get().world_from_camera()),
        Err(_) => pose_of_matrix(name, value),
    }
}

impl View {
    /// Creates a view from the trajectory to it, a robot's joints on the way, and a turntable's angle in
    /// degrees.
    pub fn new(
        next: NextView,
        trajectory: &Trajectory,
        joints: Option<JointTrajectory>,
        turntable_angle_deg: Option<f64>,
    ) -> Self {
        let values = |points: Vec<(f64, Vec<f64>)>| points.into_iter().map(|(_, values)| values).collect();
        let joints = joints.map(|JointTrajectory { names, points }| (names, values(points)));
        let point = |point: &Waypoint| (point.time, point.world_from_camera);
        let waypoints = trajectory.waypoints().iter().map(point).collect();
        Self { next, waypoints, trajectory_length: trajectory.length(), joints, turntable_angle_deg }
    }

    /// The pose, bit for bit.
    pub fn world_from_camera(&self) -> Pose {
        self.next.world_from_camera
    }
}

#[pymethods]
impl View {
    /// Number among the candidates, from 0; None for a first view that is not a candidate.
    #[getter]
    fn number(&self) -> Option<usize> {
        self.next.view
    }

    /// Pose of the camera: 4 x 4, float64, metres; the camera looks along z, and y points down.
    #[getter(world_from_camera)]
    fn matrix<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.next.world_from_camera)
    }

    /// Names of the robot's joints; None if there is no robot.
    #[getter]
    fn joint_names(&self) -> Option<Vec<String>> {
        self.joints.as_ref().map(|(names, _)| names.clone())
    }

    /// Joint values of the robot at each waypoint: N x joints, float64, radians or metres; None if there is
    /// no robot.
    #[getter]
    fn joint_values<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let values = self.joints.as_ref().map(|(_, values)| PyArray2::from_vec2(py, values));
        values.transpose().map_err(|error| internal_error(py, &error.to_string()))
    }

    /// The turntable angle for the view in degrees, 0 to 360, counter-clockwise seen from above; None if
    /// there is no turntable.
    #[getter]
    fn turntable_angle_deg(&self) -> Option<f64> {
        self.turntable_angle_deg
    }

    /// The planner's score, the quantity it maximised, in its unit; None for the first view.
    #[getter]
    fn score(&self) -> Option<f64> {
        Some(self.next.choice.as_ref()?.score)
    }

    /// Number of the second best view, if there is one.
    #[getter]
    fn runner_up(&self) -> Option<usize> {
        self.next.choice.as_ref()?.runner_up
    }

    /// The quantities behind the score by name, with units in the names; empty if the planner has none.
    #[getter]
    fn explanation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let explanation = self.next.choice.as_ref().and_then(|choice| choice.explanation.clone());
        to_python(py, &explanation.unwrap_or_default())
    }

    /// Number of voxels that this view is expected to add; None for planners without estimates.
    #[getter]
    fn expected_new_voxels(&self) -> Option<f64> {
        Some(self.next.outlook.as_ref()?.n_expected_next())
    }

    /// Number of voxels that all views together are expected to add; None for planners without estimates.
    #[getter]
    fn expected_unseen_voxels(&self) -> Option<f64> {
        Some(self.next.outlook.as_ref()?.n_unseen)
    }

    /// Estimated share, 0 to 1, of the visible surface seen before this view; None if there is no estimate.
    #[getter]
    fn estimated_completeness(&self) -> Option<f64> {
        Some(self.next.outlook.as_ref()?.completeness())
    }

    /// Estimated completeness after this view and each expected later view, as a list; None if there is no
    /// estimate.
    #[getter]
    fn forecast_completeness(&self) -> Option<Vec<f64>> {
        Some(self.next.outlook.as_ref()?.forecast())
    }

    /// Times of the waypoints in seconds since the camera sets off: N, float64.
    #[getter]
    fn waypoint_times_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray::from_vec(py, self.waypoints.iter().map(|(time, _)| *time).collect())
    }

    /// The trajectory from the last frame to this view, around the object: N x 4 x 4, float64.
    #[getter]
    fn waypoints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        poses(py, self.waypoints.iter().map(|(_, pose)| *pose))
    }

    /// Length of the trajectory in metres.
    #[getter]
    fn trajectory_length_m(&self) -> f64 {
        self.trajectory_length
    }

    /// Pickles a view bit for bit.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let NextView { view, world_from_camera, choice, outlook } = self.next.clone();
        let (waypoints, trajectory_length) = (self.waypoints.clone(), self.trajectory_length);
        let (joints, turntable_angle_deg) = (self.joints.clone(), self.turntable_angle_deg);
        let pickled = Pickled {
            view,
            world_from_camera,
            choice,
            outlook,
            waypoints,
            trajectory_length,
            joints,
            turntable_angle_deg,
        };
        let text = serde_json::to_string(&pickled).map_err(|error| internal_error(py, &error.to_string()))?;
        Ok((py.import("nextview._native")?.getattr("view_of_text")?, (text,)))
    }

    fn __repr__(&self) -> String {
        let number = self.next.view.map_or("None".to_owned(), |number| number.to_string());
        let [x, y, z] = self.next.world_from_camera.translation().to_array();
        format!("View(number={number}, position_m=[{x:.3}, {y:.3}, {z:.3}])")
    }
}
