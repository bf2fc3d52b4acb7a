//! Faults of the library as Python exceptions.

use crate::records::to_python;
use nextview_scan::{Fault, FaultKind, Faults};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::fmt;
use std::path::PathBuf;

/// Returns the exception for these faults, of the classes in `nextview.errors`.
pub fn exception(py: Python<'_>, faults: impl Into<Faults>) -> PyErr {
    let faults = faults.into();
    // Only a signal cancels a computation.
    if faults.iter().any(|fault| fault.kind == FaultKind::Cancelled) {
        return PyKeyboardInterrupt::new_err(());
    }
    let is_request = faults.iter().all(|fault| fault.kind == FaultKind::Request);
    let class = if is_request { "InputError" } else { "DataError" };
    let error = raised(py, class, &faults).unwrap_or_else(|error| error);
    if let Some(cause) = faults.iter().find_map(raised_by_planner) {
        error.set_cause(py, Some(cause.clone_ref(py)));
    }
    error
}

fn raised_by_planner(fault: &Fault) -> Option<&PyErr> {
    fault.cause.as_ref()?.0.downcast_ref::<PlannerFailure>()?.error.as_ref()
}

/// The exception for an invalid argument.
pub fn input_error(py: Python<'_>, message: impl fmt::Display) -> PyErr {
    exception(py, Fault::request(message))
}

/// The exception for a panic, which is a bug in the library.
pub fn internal_error(py: Python<'_>, message: &str) -> PyErr {
    let fault = Fault::data(format!("a bug in nextview: {message}"));
    raised(py, "InternalError", &fault.into()).unwrap_or_else(|error| error)
}

fn raised(py: Python<'_>, class: &str, faults: &Faults) -> PyResult<PyErr> {
    let class = py.import("nextview.errors")?.getattr(class)?;
    let instance = class.call_method1("_of_faults", (to_python(py, faults)?,))?;
    Ok(PyErr::from_value(instance))
}

/// A Python planner raised an exception, or returned an invalid answer.
#[derive(Debug)]
pub struct PlannerFailure {
    message: String,
    error: Option<PyErr>,
}

impl PlannerFailure {
    /// A return value other than expected, as described by the message.
    pub fn new(message: String) -> Self {
        Self { message, error: None }
    }

    /// An exception raised in this part of the planner.
    pub fn raised(py: Python<'_>, part: &str, error: PyErr) -> Self {
        let place = place(py, &error).unwrap_or_default();
        Self { message: format!("{part} raised {error}{place}"), error: Some(error) }
    }
}

/// File and line of the exception: a campaign keeps only the message.
fn place(py: Python<'_>, error: &PyErr) -> Option<String> {
    let mut last = error.traceback(py)?.into_any();
    while let Some(next) = last.getattr("tb_next").ok().filter(|next| !next.is_none()) {
        last = next;
    }
    let file: PathBuf =
        last.getattr("tb_frame").ok()?.getattr("f_code").ok()?.getattr("co_filename").ok()?.extract().ok()?;
    let line: usize = last.getattr("tb_lineno").ok()?.extract().ok()?;
    Some(format!(" ({}, line {line})", file.file_name()?.display()))
}

impl fmt::Display for PlannerFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for PlannerFailure {}

impl From<PlannerFailure> for nextview::Error {
    fn from(failure: PlannerFailure) -> Self {
        Self::Planner(Box::new(failure))
    }
}
