//! Long computations: without the interpreter's lock, and ended by Ctrl-C.

use crate::errors::{exception, internal_error};
use nextview::Cancel;
use nextview_scan::Faults;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// Time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(20);

/// Does the work on a thread of its own, while this one waits for signals: Python handles them on its main
/// thread only. A signal handler that raises cancels the work, and its exception is the result.
pub fn compute<T: Send>(
    py: Python<'_>,
    cancel: &Cancel,
    work: impl FnOnce() -> Result<T, Faults> + Send,
) -> PyResult<T> {
    let (done, result) = channel();
    let outcome = py.detach(move || {
        thread::scope(|scope| {
            scope.spawn(move || _ = done.send(catch_unwind(AssertUnwindSafe(work))));
            loop {
                match result.recv_timeout(PERIOD) {
                    Ok(outcome) => return Ok::<_, PyErr>(Some(outcome)),
                    Err(RecvTimeoutError::Disconnected) => return Ok(None),
                    Err(RecvTimeoutError::Timeout) => {
                        Python::attach(|py| py.check_signals()).inspect_err(|_| {
                            cancel.cancel();
                            _ = result.recv();
                            cancel.reset();
                        })?
                    }
                }
            }
        })
    })?;
    match outcome {
        Some(Ok(result)) => result.map_err(|faults| exception(py, faults)),
        Some(Err(panic)) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Err(internal_error(py, text.unwrap_or("no message")))
        }
        None => Err(internal_error(py, "a computation ended without a result")),
    }
}
