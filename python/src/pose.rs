//! Poses as 4 x 4 matrices.

use crate::arrays::readonly;
use crate::errors::{exception, input_error};
use crate::shown::type_of;
use nextview::geometry::Pose;
use nextview_scan::{pose_of_rows, rows_of_pose};
use numpy::{PyArray, PyArray2, PyArray3, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// The pose of a 4 x 4 matrix that takes points from camera to world.
pub fn pose_of_matrix(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Pose> {
    pose_of_rows(name, &rows(name, value)?).map_err(|fault| exception(value.py(), fault))
}

/// The matrix of a pose.
pub fn matrix<'py>(py: Python<'py>, pose: &Pose) -> Bound<'py, PyArray2<f64>> {
    let array = PyArray2::zeros(py, [4, 4], false);
    let rows = rows_of_pose(pose);
    // The array is not shared yet.
    if let Ok(mut view) = array.try_readwrite() {
        view.as_array_mut().iter_mut().zip(rows.iter().flatten()).for_each(|(entry, value)| *entry = *value);
    }
    array
}

/// Matrices of poses: N x 4 x 4.
pub fn poses<'py>(
    py: Python<'py>,
    poses: impl ExactSizeIterator<Item = Pose>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let n = poses.len();
    let entries = poses.flat_map(|pose| rows_of_pose(&pose).into_iter().flatten());
    PyArray::from_vec(py, entries.collect()).reshape([n, 4, 4])
}

fn rows(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f64; 4]; 4]> {
    let py = value.py();
    let expected = "expected a 4 x 4 array of float64, or a View";
    let Ok(array) = value.cast::<PyUntypedArray>() else {
        let kind = type_of(value);
        return Err(input_error(py, format!("`{name}` is of type {kind}, {expected}")));
    };
    if array.shape() != [4, 4] {
        return Err(input_error(py, format!("`{name}` has the shape {:?}, {expected}", array.shape())));
    }
    let Ok(array) = value.cast::<PyArray2<f64>>() else {
        return Err(input_error(py, format!("`{name}` has the type {}, {expected}", array.dtype())));
    };
    let array = readonly(name, array)?;
    let entry = |i: usize, j: usize| array.get([i, j]).copied().unwrap_or(f64::NAN);
    Ok(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}
