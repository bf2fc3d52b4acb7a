//! Long computations: without the interpreter's lock, and interruptible by Ctrl-C.

use crate::errors::{exception, internal_error};
use nextview::Cancel;
use nextview_scan::{Fault, Faults};
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// Interval between checks for signals.
const PERIOD: Duration = Duration::from_millis(20);

/// The process that computed first. A process forked from it has none of its threads, and would wait for them
/// for ever.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Does the work on a separate thread while this one waits for signals: Python handles them only on its main
/// thread. A signal handler that raises an exception cancels the work, and the exception is the result.
pub fn compute<T: Send>(
    py: Python<'_>,
    cancel: &Cancel,
    work: impl FnOnce() -> Result<T, Faults> + Send,
) -> PyResult<T> {
    let process = std::process::id();
    if *PROCESS.get_or_init(|| process) != process {
        let fault = Fault::request("this process was forked from one that had already used nextview");
        let remedy = "start processes with multiprocessing.get_context(\"spawn\"), or \"forkserver\"";
        return Err(exception(py, fault.with_remedy(remedy)));
    }
    let (done, result) = channel();
    let outcome = py.detach(move || {
        thread::scope(|scope| {
            let job = move || _ = done.send(catch_unwind(AssertUnwindSafe(work)));
            if let Err(error) = thread::Builder::new().spawn_scoped(scope, job) {
                let fault = Fault::data(format!("no thread can be started to compute in: {error}"));
                return Ok(Some(Ok(Err(fault.into()))));
            }
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
        Some(Err(panic)) => Err(of_panic(py, &*panic)),
        None => Err(internal_error(py, "a computation ended without a result")),
    }
}

/// Does short work on this thread; a panic becomes a normal exception.
pub fn guarded<T>(py: Python<'_>, work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| of_panic(py, &*panic))
}

fn of_panic(py: Python<'_>, panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    internal_error(py, text.unwrap_or("no message"))
}
