//! Cloud, mesh and map as arrays.

use glam::DVec3;
use nextview::map::{Occupancy, Snapshot};
use nextview::surface::CloudPoint;
use nextview_scan::FinalModel;
use numpy::{PyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Points, normals (NaN if missing) and, if any point has one, colours.
pub fn cloud<'py>(py: Python<'py>, points: &[CloudPoint]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("points", rows(py, points.iter().map(|point| point.position.to_array()))?)?;
    let normal = |point: &CloudPoint| point.normal.unwrap_or(DVec3::NAN).to_array();
    dict.set_item("normals", rows(py, points.iter().map(normal))?)?;
    let has_color = points.iter().any(|point| point.color.is_some());
    let color = |point: &CloudPoint| point.color.unwrap_or_default();
    let colors = has_color.then(|| rows(py, points.iter().map(color))).transpose()?;
    dict.set_item("colors", colors)?;
    Ok(dict)
}

/// Vertices with normals and colours, triangles, and for each vertex whether it was filled in.
pub fn mesh<'py>(py: Python<'py>, model: &FinalModel) -> PyResult<Bound<'py, PyDict>> {
    let dict = cloud(py, &model.vertices)?;
    dict.set_item("triangles", rows(py, model.triangles().iter().copied())?)?;
    let is_filled = model.is_filled().map(|filled| PyArray::from_vec(py, filled.to_vec()));
    dict.set_item("is_filled", is_filled)?;
    Ok(dict)
}

/// The voxels of the box as a dense grid, x first.
pub fn map<'py>(py: Python<'py>, snapshot: &Snapshot) -> PyResult<Bound<'py, PyDict>> {
    let (lattice, block) = (snapshot.lattice(), snapshot.block());
    let dims = block.dims().to_array().map(|n| n as usize);
    let [sx, sy, sz] = block.strides();
    let order = move || {
        let [nx, ny, nz] = dims;
        let index = move |x, y| (0..nz).map(move |z| x * sx + y * sy + z * sz);
        (0..nx).flat_map(move |x| (0..ny).flat_map(move |y| index(x, y)))
    };
    let state = |i: usize| match snapshot.occupancy()[i] {
        Occupancy::Unknown => 0_u8,
        Occupancy::Free => 1,
        Occupancy::Occupied => 2,
    };
    let dict = PyDict::new(py);
    dict.set_item("occupancy", PyArray::from_vec(py, order().map(state).collect()).reshape(dims)?)?;
    let probability = order().map(|i| snapshot.probability()[i]).collect();
    dict.set_item("probability", PyArray::from_vec(py, probability).reshape(dims)?)?;
    dict.set_item("origin_m", lattice.bounds(&block).min.to_array())?;
    dict.set_item("voxel_size_m", lattice.voxel_size())?;
    Ok(dict)
}

fn rows<'py, T: numpy::Element>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [T; 3]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let n = rows.len();
    PyArray::from_vec(py, rows.flatten().collect()).reshape([n, 3])
}
