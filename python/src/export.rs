//! Results in the forms of other tools.

use crate::errors::exception;
use crate::values::of_request;
use nextview_export::Format;
use nextview_scan::files::Overwrite;
use nextview_scan::{Fault, Named};
use pyo3::prelude::*;
use std::path::PathBuf;

/// `nextview.export`: the number of views, and notes.
#[pyfunction]
pub fn export(
    py: Python<'_>,
    results: PathBuf,
    to: &str,
    out: PathBuf,
    force: bool,
) -> PyResult<(usize, Vec<String>)> {
    let Some(format) = Format::of_name(to) else {
        let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
        return Err(of_request(py, Fault::of_value("to", to, names.join(", ")).into()));
    };
    let rule = if force { Overwrite::results() } else { Overwrite::nothing() };
    let exported = py.detach(|| nextview_export::export(&results, format, &out, rule));
    let exported = exported.map_err(|faults| exception(py, faults))?;
    Ok((exported.n_views, exported.notes))
}
