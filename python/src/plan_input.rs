//! The input of planners and gains in Python.

use crate::camera::numbers_of;
use crate::model;
use crate::pose::poses;
use nextview::map::Snapshot;
use nextview::planner::Situation;
use nextview::visibility::{RayEnd, ViewRays};
use numpy::PyArray1;
use pyo3::prelude::*;

/// The `nextview.Situation` of a plan.
pub fn situation<'py>(py: Python<'py>, situation: &Situation<'_>, seed: u64) -> PyResult<Bound<'py, PyAny>> {
    let module = py.import("nextview._planner")?;
    let array_of = |views: &[usize]| PyArray1::from_vec(py, views.iter().map(|&view| view as i64).collect());
    let frames = situation.frames().iter().map(|frame| frame.world_from_camera());
    module.getattr("situation_of")?.call1((
        model::map(py, situation.snapshot())?,
        poses(py, situation.views().poses().iter().copied())?,
        array_of(&situation.open_views()),
        array_of(situation.visited()),
        poses(py, frames)?,
        numbers_of(situation.intrinsics(), situation.depth_range()),
        seed,
    ))
}

/// The indices of voxels in the arrays of a `nextview.Map`, in which z changes fastest.
pub struct Grid(Vec<u32>);

impl Grid {
    /// The indices for this snapshot.
    pub fn of(snapshot: &Snapshot) -> Self {
        let [nx, ny, nz] = snapshot.block().dims().to_array();
        let column = |y: u32, z: u32| (0..nx).map(move |x| (x * ny + y) * nz + z);
        Self((0..nz).flat_map(|z| (0..ny).flat_map(move |y| column(y, z))).collect())
    }

    fn number(&self, voxel: u32) -> i64 {
        i64::from(self.0[voxel as usize])
    }
}

/// The `nextview.Rays` of a view.
pub fn rays<'py>(py: Python<'py>, view: usize, rays: &ViewRays, grid: &Grid) -> PyResult<Bound<'py, PyAny>> {
    let end = |end: &RayEnd| match end {
        RayEnd::LeftBox => (0_u8, -1, 0.0),
        RayEnd::Occupied(last) => (1, grid.number(last.voxel), last.visibility),
        RayEnd::Faded => (2, -1, 0.0),
    };
    let crossings = rays.crossings.iter();
    let voxels: Vec<i64> = crossings.clone().map(|crossing| grid.number(crossing.voxel)).collect();
    let visibilities: Vec<f32> = crossings.map(|crossing| crossing.visibility).collect();
    let offsets: Vec<i64> = rays.offsets.iter().map(|&offset| offset as i64).collect();
    let ends = || rays.ends.iter().map(end);
    py.import("nextview._planner")?.getattr("Rays")?.call1((
        view,
        PyArray1::from_vec(py, offsets),
        PyArray1::from_vec(py, voxels),
        PyArray1::from_vec(py, visibilities),
        PyArray1::from_vec(py, ends().map(|(kind, ..)| kind).collect()),
        PyArray1::from_vec(py, ends().map(|(_, voxel, _)| voxel).collect()),
        PyArray1::from_vec(py, ends().map(|(.., visibility)| visibility).collect()),
    ))
}
