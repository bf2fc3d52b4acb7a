//! Results in the formats of other tools.

use crate::errors::exception;
use crate::values::of_request;
use nextview_export::Format;
use nextview_scan::Named;
use nextview_scan::files::Overwrite;
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
    let format = Format::of_key("to", to).map_err(|fault| of_request(py, fault.into()))?;
    let exported = py.detach(|| nextview_export::export(&results, format, &out, Overwrite::forced(force)));
    let exported = exported.map_err(|faults| exception(py, faults))?;
    Ok((exported.n_views, exported.notes))
}
