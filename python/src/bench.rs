//! Campaigns: many scans by one specification.

use crate::errors::input_error;
use crate::records::to_python;
use crate::shown::type_of;
use crate::values::{of_request, table};
use crate::watch::{compute, guarded};
use nextview::Cancel;
use nextview_campaign::execution::{CampaignEvent, run_campaign};
use nextview_campaign::store::Store;
use nextview_campaign::tables::{self, Column, Table};
use nextview_campaign::{FailedRuns, RunRecord, Shard, Spec};
use nextview_scan::{Fault, Faults};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The runs of a campaign, and its folder.
struct Campaign {
    spec: Spec,
    dir: PathBuf,
    resume: bool,
    jobs: Option<usize>,
}

/// The outcome of a campaign.
struct CampaignOutcome {
    runs: Table,
    steps: Table,
    times: Table,
    failed: Vec<FailedRuns>,
}

/// Does all runs of a specification: the name of a built-in one, a file, or a dict. `on_event` is called with
/// every event.
#[pyfunction]
#[pyo3(signature = (spec, objects, out, resume, jobs, on_event))]
pub fn bench<'py>(
    py: Python<'py>,
    spec: &Bound<'py, PyAny>,
    objects: Vec<String>,
    out: PathBuf,
    resume: bool,
    jobs: Option<usize>,
    on_event: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let campaign = Campaign { spec: read_spec(spec, &objects)?, dir: out, resume, jobs };
    let cancel = Cancel::default();
    let raised = Mutex::new(None);
    let listener = |event: CampaignEvent| {
        let Some(callback) = &on_event else { return };
        let called = Python::attach(|py| callback.call1(py, (to_python(py, &event)?,)).map(drop));
        if let Err(error) = called {
            *raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            cancel.cancel();
        }
    };
    let done = compute(py, &cancel, || done(&campaign, &cancel, &listener));
    if let Some(error) = raised.lock().unwrap_or_else(PoisonError::into_inner).take() {
        return Err(error);
    }
    let CampaignOutcome { runs, steps, times, failed } = done?;
    let dict = PyDict::new(py);
    for (name, table) in [("runs", runs), ("steps", steps), ("times", times)] {
        dict.set_item(name, columns(py, table)?)?;
    }
    let failed = failed.into_iter().map(|failed| (failed.object, failed.reason, failed.n_runs));
    dict.set_item("failed", failed.collect::<Vec<_>>())?;
    Ok(dict)
}

/// Reads a specification by name, from a file, or from a dict.
pub fn read_spec(spec: &Bound<'_, PyAny>, objects: &[String]) -> PyResult<Spec> {
    let py = spec.py();
    let spec = if let Ok(dict) = spec.cast::<PyDict>() {
        if !objects.is_empty() {
            return Err(input_error(
                py,
                "`objects` is only for specifications given by name; a dict has its own",
            ));
        }
        let text = toml::to_string(&table(dict)?).map_err(|error| input_error(py, error))?;
        guarded(py, || Spec::parse(&text, Path::new("")))
    } else if let Ok(name) = spec.cast::<PyString>() {
        let name = name.to_str()?;
        guarded(py, || Spec::load(name, objects))
    } else {
        let kind = type_of(spec);
        return Err(input_error(py, format!("`spec` is of type {kind}, expected a name, a file or a dict")));
    };
    spec?.map_err(|faults| of_request(py, faults))
}

fn done(
    campaign: &Campaign,
    cancel: &Cancel,
    listener: &(dyn Fn(CampaignEvent) + Sync),
) -> Result<CampaignOutcome, Faults> {
    if campaign.jobs == Some(0) {
        return Err(Fault::of_value("jobs", 0, "at least 1").into());
    }
    let mut store = Store::open(&campaign.dir, &campaign.spec, Shard::WHOLE, campaign.resume)?;
    run_campaign(&mut store, campaign.jobs, None, cancel, listener)?;
    cancel.check()?;
    let records = store.finished();
    tables::write(&campaign.dir, &records)?;
    let records = records.iter().collect::<Result<Vec<RunRecord>, Fault>>()?;
    let records: Vec<&RunRecord> = records.iter().collect();
    let (runs, steps) = (tables::runs(&records)?, tables::steps(&records)?);
    Ok(CampaignOutcome { runs, steps, times: tables::times(&records), failed: store.failed() })
}

/// Returns columns by name: arrays of float64 with NaN for missing values, of int64 or bool if none is
/// missing, and lists of strings or None.
fn columns<'py>(py: Python<'py>, table: Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, column) in table.columns() {
        match column {
            Column::Text(texts) => dict.set_item(name, texts)?,
            Column::Float(values) => dict.set_item(name, floats(py, values.iter().copied()))?,
            Column::Int(values) => match values.iter().copied().collect::<Option<Vec<i64>>>() {
                Some(whole) => dict.set_item(name, PyArray1::from_vec(py, whole))?,
                None => dict.set_item(name, floats(py, values.iter().map(|n| n.map(|n| n as f64))))?,
            },
            Column::Bool(values) => match values.iter().copied().collect::<Option<Vec<bool>>>() {
                Some(whole) => dict.set_item(name, PyArray1::from_vec(py, whole))?,
                None => dict.set_item(name, values)?,
            },
        }
    }
    Ok(dict)
}

fn floats(py: Python<'_>, values: impl Iterator<Item = Option<f64>>) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_vec(py, values.map(|value| value.unwrap_or(f64::NAN)).collect())
}
