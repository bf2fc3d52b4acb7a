//! Results in the formats of other tools.

use crate::values::of_request;
use crate::watch::compute;
use nextview::Cancel;
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
    let export = || nextview_export::export(&results, format, &out, Overwrite::forced(force));
    let exported = compute(py, &Cancel::default(), export)?;
    Ok((exported.n_views, exported.notes))
}
