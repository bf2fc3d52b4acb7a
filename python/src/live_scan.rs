//! A scan with a user's camera.

use crate::arrays::{color_image, depth_image};
use crate::camera::{Camera, numbers_of};
use crate::errors::exception;
use crate::pictures::{self, MomentArrays, Taken};
use crate::pose::{matrix, poses};
use crate::records::to_python;
use crate::view::{View, pose_of};
use crate::watch::compute;
use crate::{model, planner, results, values};
use nextview::Cancel;
use nextview::sensor::Intrinsics;
use nextview::session::StopReason;
use nextview_scan::{Fault, Faults, LiveFrame, Measured};
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, TryLockError};

/// The engine of `nextview.Scan`.
#[pyclass(frozen, module = "nextview._native")]
pub struct LiveScan {
    scan: Mutex<nextview_scan::LiveScan>,
    camera: Intrinsics,
    cancel: Cancel,
    /// Whether its own folder contains its results, which it may replace.
    is_saved: AtomicBool,
}

#[pymethods]
impl LiveScan {
    #[new]
    #[pyo3(signature = (config, camera, bounds, first_pose, poses, out, force))]
    #[expect(clippy::too_many_arguments, reason = "a value that no configuration has")]
    fn new(
        py: Python<'_>,
        config: &Bound<'_, PyDict>,
        camera: &Camera,
        bounds: Option<&Bound<'_, PyAny>>,
        first_pose: Option<&Bound<'_, PyAny>>,
        poses: Option<Vec<Bound<'_, PyAny>>>,
        out: Option<PathBuf>,
        force: bool,
    ) -> PyResult<Self> {
        let mut config = values::config(config)?;
        config.camera = camera.intrinsics;
        let live = config.source.to_live().map_err(|fault| exception(py, fault))?;
        (live.min_depth_m, live.max_depth_m) = (camera.depth_range.min, camera.depth_range.max);
        live.box_m = bounds.map(box_of).transpose()?;
        live.first_pose = first_pose.map(|pose| pose_of("first_pose", pose)).transpose()?;
        if poses.as_ref().is_some_and(Vec::is_empty) {
            let fault = Fault::of_value("poses", "empty", "at least one pose");
            let remedy = "without `poses`, `view_space` makes candidates around the object";
            return Err(exception(py, fault.with_remedy(remedy)));
        }
        let numbered = poses.iter().flatten().enumerate();
        live.poses =
            numbered.map(|(i, pose)| pose_of(&format!("poses[{i}]"), pose)).collect::<PyResult<_>>()?;
        Self::opened(py, |cancel| {
            out.iter().try_for_each(|dir| results::begin(dir, force, config.inputs()).map(drop))?;
            nextview_scan::LiveScan::begin(config, out.as_deref(), cancel)
        })
    }

    /// Resumes the scan in a folder.
    #[staticmethod]
    fn resume(py: Python<'_>, dir: PathBuf) -> PyResult<Self> {
        Self::opened(py, |cancel| nextview_scan::LiveScan::resume(&dir, cancel))
    }

    /// The unreadable part of the resumed scan.
    fn damage(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.with(py, |scan| Ok(scan.damage().map(ToString::to_string)))
    }

    fn next_view(&self, py: Python<'_>) -> PyResult<Option<View>> {
        self.with(py, |scan| {
            let Some(next) = scan.next()? else { return Ok(None) };
            let trajectory = scan.trajectory_to(&next)?;
            let angle = scan.turntable_angle_deg(&next.world_from_camera);
            let joints = scan.joints_to(&next).cloned();
            Ok(Some(View::new(next, &trajectory, joints, angle)))
        })
    }

    #[pyo3(signature = (depth, world_from_camera, color, depth_scale_m, mask))]
    fn observe<'py>(
        &self,
        py: Python<'py>,
        depth: &Bound<'py, PyAny>,
        world_from_camera: Option<&Bound<'py, PyAny>>,
        color: Option<&Bound<'py, PyAny>>,
        depth_scale_m: Option<f64>,
        mask: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let world_from_camera =
            world_from_camera.map(|pose| pose_of("world_from_camera", pose)).transpose()?;
        let image = depth_image(&self.camera, depth, depth_scale_m, mask)?;
        let color = color.map(|color| color_image(&self.camera, color)).transpose()?;
        let taken = LiveFrame { depth: image, world_from_camera, color, name: None };
        let step = self.with(py, |scan| Ok(scan.observe(taken)?.clone()))?;
        to_python(py, &step)
    }

    #[pyo3(signature = (depth, depth_scale_m, mask))]
    fn locate<'py>(
        &self,
        py: Python<'py>,
        depth: &Bound<'py, PyAny>,
        depth_scale_m: Option<f64>,
        mask: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let image = depth_image(&self.camera, depth, depth_scale_m, mask)?;
        let pose = self.with(py, |scan| Ok(scan.locate(&image)?))?;
        Ok(matrix(py, &pose))
    }

    fn turntable_pose<'py>(&self, py: Python<'py>, angle_deg: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let pose = self.with(py, |scan| Ok(scan.turntable_pose(angle_deg)?))?;
        Ok(matrix(py, &pose))
    }

    fn guidance<'py>(
        &self,
        py: Python<'py>,
        world_from_camera: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let pose = pose_of("world_from_camera", world_from_camera)?;
        to_python(py, &self.with(py, |scan| Ok(scan.guidance(&pose)?))?)
    }

    fn skip(&self, py: Python<'_>, view: usize, reason: &str) -> PyResult<()> {
        self.with(py, |scan| Ok(scan.skip(view, reason)?))
    }

    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let record = self.with(py, |scan| Ok(scan.scan().record(scan.config(), Measured::Nothing)?))?;
        to_python(py, &record)
    }

    fn steps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.with(py, |scan| Ok(scan.scan().steps.clone()))?)
    }

    fn n_steps(&self, py: Python<'_>) -> PyResult<usize> {
        self.with(py, |scan| Ok(scan.scan().steps.len()))
    }

    fn config<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.with(py, |scan| Ok(scan.config().clone()))?)
    }

    /// The numbers of the camera, for its constructor.
    fn camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (intrinsics, live) =
            self.with(py, |scan| Ok((scan.config().camera, scan.config().source.live().cloned())))?;
        Ok(numbers_of(&intrinsics, live.unwrap_or_default().depth_range()).into_pyobject(py)?.into_any())
    }

    /// Returns cloud and mesh.
    fn model<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let model = self.with(py, |scan| Ok(scan.scan().model(scan.config().model)?))?;
        Ok((model::cloud(py, &model.cloud)?, model::mesh(py, &model)?))
    }

    fn map<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let snapshot = self.with(py, |scan| Ok(scan.scan().session.snapshot()))?;
        snapshot.map(|snapshot| model::map(py, &snapshot)).transpose()
    }

    /// The page of the scan in its current state.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |scan| {
            let record = scan.scan().record(scan.config(), Measured::Nothing)?;
            pictures::page(scan.scan(), scan.config(), &record)
        })
    }

    /// Depths and mapped pose of the frame of a step, from 0.
    fn frame<'py>(&self, py: Python<'py>, step_idx: usize) -> PyResult<Taken<'py>> {
        let frame = self.with(py, |scan| Ok(scan.scan().frame(step_idx)?.clone()))?;
        pictures::arrays_of(py, &frame)
    }

    /// The state of knowledge after each frame.
    fn moments<'py>(&self, py: Python<'py>) -> PyResult<Vec<MomentArrays<'py>>> {
        let moments = self.with(py, |scan| pictures::moments(scan.scan(), scan.config()))?;
        moments.into_iter().map(|moment| moment.arrays(py)).collect()
    }

    fn candidates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let views = self.with(py, |scan| Ok(scan.scan().session.views().poses().to_vec()))?;
        poses(py, views.into_iter())
    }

    fn stop_reason<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.with(py, |scan| Ok(scan.stop_reason()))?)
    }

    /// Writes the results. With `is_own`, this is the folder in which the scan was begun; its journal is not
    /// needed once the scan is over.
    fn save(&self, py: Python<'_>, dir: PathBuf, force: bool, is_own: bool) -> PyResult<()> {
        self.with(py, |scan| {
            let force = force || (is_own && self.is_saved.load(Ordering::Relaxed));
            let folder = results::begin(&dir, force, scan.config().inputs())?;
            let (_, faults) =
                results::publish(folder, scan.config(), scan.scan(), "nextview.Scan in Python")?;
            self.is_saved.fetch_or(is_own, Ordering::Relaxed);
            faults.map_or(Ok(()), Err)?;
            let is_over = scan.stop_reason().is_some_and(|reason| reason != StopReason::NoObject);
            if is_own && is_over {
                scan.forget_journal();
            }
            Ok(())
        })
    }
}

/// Lowest and highest corners.
fn box_of(value: &Bound<'_, PyAny>) -> PyResult<[f64; 6]> {
    let expected = "its lowest and its highest corner, 2 x 3 numbers";
    let corners = values::numbers("box", value, |shape| matches!(shape, [2, 3] | [6]), expected)?;
    Ok(std::array::from_fn(|i| corners[i]))
}

impl LiveScan {
    fn opened(
        py: Python<'_>,
        open: impl FnOnce(Cancel) -> Result<nextview_scan::LiveScan, Faults> + Send,
    ) -> PyResult<Self> {
        let cancel = Cancel::default();
        let scan = compute(py, &cancel, || open(cancel.clone()))?;
        let camera = scan.config().camera;
        Ok(Self { scan: Mutex::new(scan), camera, cancel, is_saved: AtomicBool::new(false) })
    }

    /// Runs a closure on the scan, without the interpreter's lock.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut nextview_scan::LiveScan) -> Result<T, Faults> + Send,
    ) -> PyResult<T> {
        // A scan waits for its planner: a planner that calls it would wait for itself.
        let can_wait = !planner::is_called();
        compute(py, &self.cancel, || {
            let scan = match can_wait {
                true => self.scan.lock().map_err(TryLockError::from),
                false => self.scan.try_lock(),
            };
            match scan {
                Ok(mut scan) => work(&mut scan),
                Err(TryLockError::WouldBlock) => {
                    let fault = Fault::request("a planner cannot use the scan that asks it");
                    Err(fault.with_remedy("its situation holds everything that it may use").into())
                }
                Err(TryLockError::Poisoned(_)) => {
                    let message = "this scan failed earlier because of a bug in nextview; start a new one";
                    Err(Fault::data(message).into())
                }
            }
        })
    }
}
