//! Poses as 4 x 4 matrices.

use crate::errors::{exception, input_error};
use crate::view::View;
use glam::{DMat3, DQuat, DVec3};
use nextview::geometry::Pose;
use numpy::{PyArray2, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// How far the product of a rotation with its transpose may be from the identity: matrices of 32-bit
/// numbers are off by 1e-6, a calibration that was rounded to four digits by 1e-3.
const TOLERANCE: f64 = 1e-3;

/// The pose of a view, or of a 4 x 4 matrix that takes points of the camera to the world. The matrix of a
/// view loses the last bits of its pose, which the view itself has.
pub fn pose_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Pose> {
    let py = value.py();
    if let Ok(view) = value.cast::<View>() {
        return Ok(view.get().world_from_camera());
    }
    let rows = rows(name, value)?;
    of_rows(&rows).map_err(|problem| match problem {
        Problem::Text(text) => input_error(py, format!("`{name}`: {text}")),
        Problem::Library(error) => {
            exception(py, nextview_scan::Fault::from(error).within(format!("`{name}`")))
        }
    })
}

/// The matrix of a pose.
pub fn matrix<'py>(py: Python<'py>, pose: &Pose) -> Bound<'py, PyArray2<f64>> {
    let array = PyArray2::zeros(py, [4, 4], false);
    let rows = rows_of(pose);
    // Nobody else has the array yet.
    if let Ok(mut view) = array.try_readwrite() {
        view.as_array_mut().iter_mut().zip(rows.iter().flatten()).for_each(|(entry, value)| *entry = *value);
    }
    array
}

/// The rows of the matrix of a pose.
pub fn rows_of(pose: &Pose) -> [[f64; 4]; 4] {
    let (r, t) = (pose.rotation_matrix(), pose.translation());
    let row = |i: usize| [r.col(0)[i], r.col(1)[i], r.col(2)[i], t[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

enum Problem {
    Text(String),
    Library(nextview::Error),
}

fn rows(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f64; 4]; 4]> {
    let py = value.py();
    let expected = "expected a 4 x 4 array of float64, or a View";
    let Ok(array) = value.cast::<PyUntypedArray>() else {
        let kind = value.get_type().name()?;
        return Err(input_error(py, format!("`{name}` is of type {kind}, {expected}")));
    };
    if array.shape() != [4, 4] {
        return Err(input_error(py, format!("`{name}` has the shape {:?}, {expected}", array.shape())));
    }
    let Ok(array) = value.cast::<PyArray2<f64>>() else {
        return Err(input_error(py, format!("`{name}` is of {}, {expected}", array.dtype())));
    };
    let array = array.try_readonly().map_err(|error| input_error(py, format!("`{name}`: {error}")))?;
    let entry = |i: usize, j: usize| array.get([i, j]).copied().unwrap_or(f64::NAN);
    Ok(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}

fn of_rows(rows: &[[f64; 4]; 4]) -> Result<Pose, Problem> {
    if let Some(entry) = rows.iter().flatten().find(|entry| !entry.is_finite()) {
        return Err(Problem::Text(format!("an entry is {entry}, expected finite numbers")));
    }
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        let is_transposed = rows[3][3] == 1.0 && (0..3).all(|i| rows[i][3] == 0.0);
        let hint = if is_transposed { "; is the matrix transposed?" } else { "" };
        return Err(Problem::Text(format!("the last row is {:?}, expected 0 0 0 1{hint}", rows[3])));
    }
    let rotation = DMat3::from_cols_array_2d(&std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j])));
    let product = rotation * rotation.transpose() - DMat3::IDENTITY;
    let error = product.to_cols_array().into_iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
    let determinant = rotation.determinant();
    if error.is_nan() || error > TOLERANCE {
        return Err(Problem::Text(format!(
            "the rotation is not rigid: its rows are off unit length or right angles by {error:.3}, its \
             determinant is {determinant:.3}; expected a rotation within {TOLERANCE}"
        )));
    }
    if determinant < 0.0 {
        let text = "the rotation mirrors: its determinant is -1, expected 1; is an axis left-handed?";
        return Err(Problem::Text(text.to_owned()));
    }
    let translation = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
    Pose::new(DQuat::from_mat3(&rotation).normalize(), translation).map_err(Problem::Library)
}
