//! A whole scan of a simulated object or of recorded frames, as by the program's `scan`.

use crate::camera::Camera;
use crate::pictures::Finished;
use crate::records::to_python;
use crate::watch::compute;
use crate::{model, results, values};
use nextview::Cancel;
use nextview::map::Snapshot;
use nextview_scan::{
    Fault, Faults, FinalModel, FrameSource, Measured, RecordedScan, RunOptions, ScanConfig, ScanRecord,
    ScanRun, SimulatedObject, Simulation, SourceConfig, Truth,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The outcome of a scan.
struct ScanOutcome {
    record: ScanRecord,
    model: Option<FinalModel>,
    snapshot: Option<Snapshot>,
    finished: Finished,
    config: ScanConfig,
    notes: Vec<String>,
}

/// Where results go.
struct ScanOutput<'a> {
    dir: Option<&'a Path>,
    force: bool,
}

/// Runs the configured scan. `on_step` is called with the record of every step.
#[pyfunction]
#[pyo3(signature = (config, camera, out, force, on_step))]
pub fn scan<'py>(
    py: Python<'py>,
    config: &Bound<'py, PyDict>,
    camera: Option<&Camera>,
    out: Option<PathBuf>,
    force: bool,
    on_step: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut config = values::config(config)?;
    if let Some(camera) = camera {
        config.camera = camera.intrinsics;
    }
    let cancel = Cancel::default();
    let listener = StepListener { callback: on_step, raised: Mutex::new(None) };
    let output = ScanOutput { dir: out.as_deref(), force };
    let done = compute(py, &cancel, || done(config, &output, &cancel, &listener));
    if let Some(error) = listener.raised.lock().unwrap_or_else(PoisonError::into_inner).take() {
        return Err(error);
    }
    as_dict(py, done?)
}

fn as_dict<'py>(py: Python<'py>, done: ScanOutcome) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("record", to_python(py, &done.record)?)?;
    dict.set_item("config", to_python(py, &done.config)?)?;
    dict.set_item("notes", &done.notes)?;
    let cloud = done.model.as_ref().map(|model| model::cloud(py, &model.cloud)).transpose()?;
    dict.set_item("cloud", cloud)?;
    dict.set_item("mesh", done.model.as_ref().map(|model| model::mesh(py, model)).transpose()?)?;
    dict.set_item("engine", Bound::new(py, done.finished)?)?;
    dict.set_item("map", done.snapshot.as_ref().map(|map| model::map(py, map)).transpose()?)?;
    Ok(dict)
}

/// Calls back with every step.
struct StepListener {
    callback: Option<Py<PyAny>>,
    /// The exception raised by a call.
    raised: Mutex<Option<PyErr>>,
}

impl StepListener {
    fn call(&self, step: &nextview_scan::StepRecord) -> Result<(), Fault> {
        let Some(callback) = &self.callback else { return Ok(()) };
        let called = Python::attach(|py| callback.call1(py, (to_python(py, step)?,)).map(drop));
        called.map_err(|error| {
            *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            Fault::request("the listener raised an exception")
        })
    }
}

fn done(
    config: ScanConfig,
    output: &ScanOutput<'_>,
    cancel: &Cancel,
    listener: &StepListener,
) -> Result<ScanOutcome, Faults> {
    output.dir.iter().try_for_each(|dir| results::begin(dir, output.force, config.inputs()).map(drop))?;
    match &config.source {
        SourceConfig::Live(_) => {
            let fault = Fault::request("the frames of `live` come from a user's camera");
            Err(fault.with_remedy("scan with nextview.Scan").into())
        }
        SourceConfig::Recording(_) => recorded(config, output, cancel, listener),
        SourceConfig::Simulated => simulated(config, output, cancel, listener),
    }
}

fn simulated(
    mut config: ScanConfig,
    output: &ScanOutput<'_>,
    cancel: &Cancel,
    listener: &StepListener,
) -> Result<ScanOutcome, Faults> {
    let object = SimulatedObject::new(&config)?;
    config.voxel_size_m = Some(object.voxel_size);
    config.views = Some(config.max_views(object.views.len()));
    let truth = config.needs_truth().then(|| Truth::new(&object, cancel, || ())).transpose()?;
    let simulation = Simulation::new(&object, &config, truth.as_ref());
    driven(&simulation, &config, object.notes(), output, cancel, listener)
}

fn recorded(
    mut config: ScanConfig,
    output: &ScanOutput<'_>,
    cancel: &Cancel,
    listener: &StepListener,
) -> Result<ScanOutcome, Faults> {
    let mut scan = RecordedScan::open(&mut config)?;
    scan.look(&config, cancel)?;
    let notes = scan.notes().iter().cloned().chain(scan.skipped()).collect();
    driven(&scan, &config, notes, output, cancel, listener)
}

fn driven(
    source: &dyn FrameSource,
    config: &ScanConfig,
    notes: Vec<String>,
    output: &ScanOutput<'_>,
    cancel: &Cancel,
    listener: &StepListener,
) -> Result<ScanOutcome, Faults> {
    let mut run =
        ScanRun::begin(source, config, RunOptions { cancel: cancel.clone(), ..RunOptions::default() })?;
    let reason = run.drive(|step| listener.call(step))?;
    cancel.check()?;
    let scan = run.finish(Some(reason));
    let has_object = scan.bounds().is_some();
    let model = has_object.then(|| scan.model(config.model)).transpose()?;
    let record = match output.dir {
        Some(dir) => {
            let folder = results::begin(dir, output.force, config.inputs())?;
            let (record, faults) =
                results::publish(folder, config, &scan, "nextview scan --config config.toml")?;
            faults.map_or(Ok(record), Err)?
        }
        None => scan.record(config, model.as_ref().map_or(Measured::Nothing, Measured::Model))?,
    };
    let snapshot = scan.session.snapshot();
    let finished = Finished::new(scan, config.clone(), record.clone());
    Ok(ScanOutcome { record, model, snapshot, finished, config: config.clone(), notes })
}
