//! Poses as 4 x 4 matrices.

use crate::arrays::readonly;
use crate::errors::{exception, input_error};
use crate::values::type_of;
use crate::view::View;
use nextview::geometry::Pose;
use nextview_scan::{pose_of_rows, rows_of_pose};
use numpy::{PyArray2, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// The pose of a view, or of a 4 x 4 matrix that takes points from camera to world. A view's matrix loses the
/// last bits of its pose, unlike the view itself.
pub fn pose_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Pose> {
    let py = value.py();
    if let Ok(view) = value.cast::<View>() {
        return Ok(view.get().world_from_camera());
    }
    pose_of_rows(name, &rows(name, value)?).map_err(|fault| exception(py, fault))
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
        return Err(input_error(py, format!("`{name}` is of {}, {expected}", array.dtype())));
    };
    let array = readonly(name, array)?;
    let entry = |i: usize, j: usize| array.get([i, j]).copied().unwrap_or(f64::NAN);
    Ok(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}
