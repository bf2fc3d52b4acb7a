//! A simulated object in front of a simulated camera.

use crate::arrays::depths;
use crate::camera::{Camera, numbers_of};
use crate::errors::exception;
use crate::pose::{matrix, poses};
use crate::values;
use crate::view::pose_of;
use crate::watch::compute;
use nextview::Cancel;
use nextview::geometry::Aabb;
use nextview_scan::{Fault, ScanConfig, SimulatedObject};
use nextview_sim::evaluator;
use nextview_sim::truth::TrueVisibility;
use numpy::{PyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::OnceLock;

/// The engine of `nextview.SimulatedScene`.
#[pyclass(frozen, module = "nextview._native")]
pub struct Scene {
    object: SimulatedObject,
    config: ScanConfig,
    truth: OnceLock<TrueVisibility>,
}

/// Lowest and highest corners.
type Corners = ([f64; 3], [f64; 3]);

/// A depth image, and the pose that the camera claims for it.
type ClaimedImage<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl Scene {
    #[new]
    fn new(py: Python<'_>, config: &Bound<'_, PyDict>, camera: Option<&Camera>) -> PyResult<Self> {
        let mut config = values::config(config)?;
        if let Some(camera) = camera {
            config.camera = camera.intrinsics;
        }
        let object = compute(py, &Cancel::default(), || SimulatedObject::new(&config))?;
        Ok(Self { object, config, truth: OnceLock::new() })
    }

    /// Returns the depth image from a pose, and the pose that the camera claims.
    fn capture<'py>(
        &self,
        py: Python<'py>,
        world_from_camera: &Bound<'py, PyAny>,
        is_first: bool,
    ) -> PyResult<ClaimedImage<'py>> {
        let pose = pose_of("world_from_camera", world_from_camera)?;
        let frame = compute(py, &Cancel::default(), || {
            Ok(evaluator::capture(&self.object.scene, &pose, is_first)?.0)
        })?;
        Ok((depths(py, frame.image())?, matrix(py, &frame.world_from_camera())))
    }

    /// The numbers of the camera, for its constructor.
    fn camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut range = self.config.noise.depth_range();
        range.max = range.max.min(nextview_sim::scene::CAMERA_RANGE);
        Ok(numbers_of(&self.config.camera, range).into_pyobject(py)?.into_any())
    }

    fn candidates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        poses(py, self.object.views.poses().iter().copied())
    }

    /// Share of the reachable surface seen after each of these candidates.
    fn coverage_curve<'py>(&self, py: Python<'py>, views: Vec<usize>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let object = &self.object;
        let n_views = object.views.len();
        if let Some(view) = views.iter().find(|view| **view >= n_views) {
            let fault = Fault::of_value("views", view, format!("0 to {}", n_views - 1));
            return Err(exception(py, fault));
        }
        let look = || TrueVisibility::new(object.scene.camera(), &object.object_voxels, &object.views, || ());
        let curve = compute(py, &Cancel::default(), || {
            let truth = match self.truth.get() {
                Some(truth) => truth,
                None => {
                    let truth = look()?;
                    self.truth.get_or_init(|| truth)
                }
            };
            Ok(truth.coverage_curve(&views))
        })?;
        Ok(PyArray::from_vec(py, curve))
    }

    /// The box around the true object, in which a scan plans.
    fn box_m(&self) -> Corners {
        corners(self.object.scene.planning_box(self.object.voxel_size))
    }

    /// The walls of the room; the lowest z is that of the table, if there is one.
    fn room_m(&self) -> Corners {
        corners(self.object.scene.room())
    }

    fn voxel_size_m(&self) -> f64 {
        self.object.voxel_size
    }

    fn description(&self) -> String {
        self.object.description()
    }
}

fn corners(bounds: Aabb) -> Corners {
    (bounds.min.to_array(), bounds.max.to_array())
}
