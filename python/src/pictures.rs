//! Data for pictures of a scan, in addition to its record.

use crate::arrays::depths;
use crate::pose::{matrix, poses};
use crate::watch::compute;
use nextview::Cancel;
use nextview::gain::UnobservedVoxel;
use nextview::map::{Occupancy, Snapshot};
use nextview::planner::{Greedy, GreedyConfig, Situation};
use nextview::sensor::Frame;
use nextview_report::page_of_scan;
use nextview_scan::{Fault, Faults, ScanConfig, ScanRecord, ScanState};
use numpy::{PyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A finished scan with its record.
#[pyclass(frozen, module = "nextview._native")]
pub struct Finished {
    scan: Mutex<ScanState<'static>>,
    config: ScanConfig,
    record: ScanRecord,
}

/// A depth image and its mapped pose.
pub type Taken<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f64>>);

/// Step, centres of the occupied voxels, and the candidates' gains.
pub type MomentArrays<'py> = (usize, Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<f64>>);

impl Finished {
    /// Stores the scan and its record.
    pub fn new(scan: ScanState<'_>, config: ScanConfig, record: ScanRecord) -> Self {
        Self { scan: Mutex::new(scan.without_source()), config, record }
    }

    fn scan(&self) -> MutexGuard<'_, ScanState<'static>> {
        self.scan.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Finished {
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let cancel = self.scan().session.cancel().clone();
        compute(py, &cancel, || page(&self.scan(), &self.config, &self.record))
    }

    fn frame<'py>(&self, py: Python<'py>, step_idx: usize) -> PyResult<Taken<'py>> {
        let frame = compute(py, &Cancel::default(), || Ok(self.scan().frame(step_idx)?.clone()))?;
        arrays_of(py, &frame)
    }

    fn moments<'py>(&self, py: Python<'py>) -> PyResult<Vec<MomentArrays<'py>>> {
        let cancel = self.scan().session.cancel().clone();
        let moments = compute(py, &cancel, || moments(&self.scan(), &self.config))?;
        moments.into_iter().map(|moment| moment.arrays(py)).collect()
    }

    fn candidates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let views = self.scan().session.views().poses().to_vec();
        poses(py, views.into_iter())
    }
}

/// The page of a scan with its record.
pub fn page(scan: &ScanState<'_>, config: &ScanConfig, record: &ScanRecord) -> Result<String, Faults> {
    let text = toml::to_string(config).map_err(Fault::data)?;
    Ok(page_of_scan(scan, record, config, "nextview in Python", &text))
}

/// Depths and pose of a frame.
pub fn arrays_of<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Taken<'py>> {
    Ok((depths(py, frame.image())?, matrix(py, &frame.world_from_camera())))
}

/// The state of knowledge after a frame.
pub struct Moment {
    step_idx: usize,
    occupied: Vec<f32>,
    gains: Vec<f64>,
}

impl Moment {
    /// Converts to arrays.
    pub fn arrays<'py>(self, py: Python<'py>) -> PyResult<MomentArrays<'py>> {
        let n = self.occupied.len() / 3;
        let occupied = PyArray::from_vec(py, self.occupied).reshape([n, 3])?;
        Ok((self.step_idx, occupied, PyArray::from_vec(py, self.gains)))
    }
}

/// The state of knowledge after each frame of the map, and the gain of each candidate at that time: the
/// entropy of the visible unobserved voxels in nats. Empty before an object was found.
pub fn moments(scan: &ScanState<'_>, config: &ScanConfig) -> Result<Vec<Moment>, Faults> {
    let session = &scan.session;
    let views: Vec<usize> = (0..session.views().len()).collect();
    let planner = Greedy::<UnobservedVoxel>::new(GreedyConfig::default())?;
    let moment = |(&step_idx, snapshot): (&usize, Result<Snapshot, nextview::Cancelled>)| {
        let snapshot = snapshot?;
        let situation = Situation::new(&snapshot, session.views(), &config.camera, session.cancel());
        let gains = planner.gains(&situation, &views)?;
        Ok(Moment { step_idx, occupied: occupied(&snapshot), gains })
    };
    session.frame_numbers().iter().zip(session.replay()).map(moment).collect()
}

fn occupied(snapshot: &Snapshot) -> Vec<f32> {
    let (lattice, block) = (snapshot.lattice(), snapshot.block());
    let is_occupied = |index: &usize| snapshot.occupancy()[*index] == Occupancy::Occupied;
    let center = |index: usize| lattice.center(block.key(index)).as_vec3().to_array();
    (0..block.n_voxels()).filter(is_occupied).flat_map(center).collect()
}
