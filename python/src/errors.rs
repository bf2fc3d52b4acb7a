//! Faults of the library as Python exceptions.

use crate::values::to_python;
use nextview_scan::{Fault, FaultKind, Faults};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// The exception of these faults, as classes in `nextview.errors` describe them.
pub fn exception(py: Python<'_>, faults: impl Into<Faults>) -> PyErr {
    let faults = faults.into();
    // A computation is cancelled by a signal only.
    if faults.iter().any(|fault| fault.kind == FaultKind::Cancelled) {
        return PyKeyboardInterrupt::new_err(());
    }
    let is_request = faults.iter().all(|fault| fault.kind == FaultKind::Request);
    let class = if is_request { "InputError" } else { "DataError" };
    raised(py, class, &faults).unwrap_or_else(|error| error)
}

/// The exception of an argument that cannot be used.
pub fn input_error(py: Python<'_>, message: impl std::fmt::Display) -> PyErr {
    exception(py, Fault::request(message))
}

/// The exception of a panic: a fault of ours.
pub fn internal_error(py: Python<'_>, message: &str) -> PyErr {
    let fault = Fault::data(format!("a fault in nextview: {message}"));
    raised(py, "InternalError", &fault.into()).unwrap_or_else(|error| error)
}

fn raised(py: Python<'_>, class: &str, faults: &Faults) -> PyResult<PyErr> {
    let class = py.import("nextview.errors")?.getattr(class)?;
    let instance = class.call_method1("of_faults", (to_python(py, faults)?,))?;
    Ok(PyErr::from_value(instance))
}
