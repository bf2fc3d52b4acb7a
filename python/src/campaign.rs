//! Campaigns with runs done by other processes.

use crate::bench::read_spec;
use crate::errors::internal_error;
use crate::records::to_python;
use crate::watch::compute;
use nextview::Cancel;
use nextview_campaign::execution::{self, Dispatch};
use nextview_campaign::store::Store;
use nextview_campaign::{RunRecord, Shard};
use nextview_scan::{Fault, Faults, TruthCache};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The campaign in a folder, which distributes runs and stores their records.
#[pyclass(frozen, module = "nextview._native")]
pub struct Campaign(Mutex<Dispatch>);

#[pymethods]
impl Campaign {
    /// Begins or resumes the campaign in a folder.
    #[new]
    fn new(py: Python<'_>, spec: &Bound<'_, PyAny>, objects: Vec<String>, out: PathBuf) -> PyResult<Self> {
        let spec = read_spec(spec, &objects)?;
        let store = compute(py, &Cancel::default(), || Store::open(&out, &spec, Shard::WHOLE, true))?;
        Ok(Self(Mutex::new(Dispatch::new(store))))
    }

    /// The events before the first batch.
    fn beginning<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &compute(py, &Cancel::default(), || Ok(self.lock().beginning()))?)
    }

    /// The next batch for this number of workers, as name and text; None if all runs are distributed.
    fn take(&self, py: Python<'_>, n_workers: usize) -> PyResult<Option<(String, String)>> {
        let taken = |batch: execution::Batch| Ok((batch.to_string(), batch.to_json()?));
        compute(py, &Cancel::default(), || self.lock().take(n_workers).map(taken).transpose())
    }

    /// Stores the record of a run; returns the resulting events.
    fn keep<'py>(&self, py: Python<'py>, record: &str) -> PyResult<Bound<'py, PyAny>> {
        let kept = compute(py, &Cancel::default(), || {
            let unreadable = |error| Fault::data(format!("the record of a run cannot be read: {error}"));
            let record: RunRecord = serde_json::from_str(record).map_err(unreadable)?;
            Ok(self.lock().keep(&record)?)
        });
        to_python(py, &kept?)
    }

    /// Writes the tables; returns the failed runs by object and reason.
    fn finish(&self, py: Python<'_>) -> PyResult<Vec<(String, String, usize)>> {
        let failed = compute(py, &Cancel::default(), || self.lock().finish())?;
        Ok(failed.into_iter().map(|failed| (failed.object, failed.reason, failed.n_runs)).collect())
    }
}

impl Campaign {
    fn lock(&self) -> MutexGuard<'_, Dispatch> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The records of a batch, each as text as soon as its run is done.
#[pyclass(frozen, module = "nextview._native")]
pub struct BatchRuns(Mutex<execution::BatchRuns>);

#[pymethods]
impl BatchRuns {
    /// Begins the batch in this text with this number of threads; truths in the cache folder are not computed
    /// again.
    #[new]
    #[pyo3(signature = (text, n_threads, truth_cache, truth_cache_mb))]
    fn new(
        py: Python<'_>,
        text: &str,
        n_threads: usize,
        truth_cache: Option<PathBuf>,
        truth_cache_mb: u64,
    ) -> PyResult<Self> {
        let runs = compute(py, &Cancel::default(), || {
            let batch = execution::Batch::from_json(text)?;
            let truths = truth_cache.map(|dir| TruthCache::open(&dir, truth_cache_mb)).transpose()?;
            batch.begin(n_threads, truths)
        })?;
        Ok(Self(Mutex::new(runs)))
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let cancel = Cancel::default();
        let record = compute(py, &cancel, || {
            let mut runs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            Ok::<_, Faults>(runs.next_record(&cancel)?)
        })?;
        let text = record.map(|record| serde_json::to_string(&record)).transpose();
        text.map_err(|error| internal_error(py, &error.to_string()))
    }
}
