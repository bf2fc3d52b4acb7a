//! Process-wide settings of a program.

use crate::Fault;
use std::io;
use std::num::NonZero;
use std::thread::available_parallelism;

/// Maximum number of threads per core: more would spend their time looking for work.
const MOST_PER_CORE: usize = 4;

/// Makes it an error, like a full disk, if a file exceeds the size limit of this process (`ulimit -f`). By
/// default, the system kills the process (SIGXFSZ), except under Python.
///
/// Call it in the first line of a program.
pub fn limit_is_an_error() -> io::Result<()> {
    // With any handler installed, the system returns an error.
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default())?;
    Ok(())
}

/// Starts the threads of all computations, by default one per core: a system limit on threads then fails
/// before there is work to lose. Returns their number if it is less than requested; the maximum is four per
/// core.
pub fn start_threads(wanted: Option<usize>) -> Result<Option<usize>, Fault> {
    let most = MOST_PER_CORE * available_parallelism().map_or(1, NonZero::get);
    let n = wanted.map_or(0, |wanted| wanted.min(most));
    rayon::ThreadPoolBuilder::new().num_threads(n).build_global().map_err(|error| {
        let fault = Fault::data(format!("the threads cannot be started: {error}"));
        fault.with_remedy("take fewer (`threads`), or allow more processes or memory (ulimit -u, ulimit -v)")
    })?;
    Ok(wanted.filter(|wanted| *wanted > most).map(|_| most))
}
