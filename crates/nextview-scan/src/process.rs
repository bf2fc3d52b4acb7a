//! What a program has the system do with its process.

use crate::Fault;
use std::io;
use std::num::NonZero;
use std::thread::available_parallelism;

/// Most threads for each core: with more, they spend their time looking for work with each other.
const MOST_PER_CORE: usize = 4;

/// From now on, a file that grows beyond the limit of this process (`ulimit -f`) is an error, as a full disk
/// is. Otherwise the system ends the process there (SIGXFSZ), as it does elsewhere than in Python.
///
/// For the first line of a program.
pub fn limit_is_an_error() -> io::Result<()> {
    // With a handler, whatever it does, the system returns an error.
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default())?;
    Ok(())
}

/// Starts the threads of all computations, by default one for each core, so that a system that allows no more
/// of them says so before there is any work to lose. Returns their number where fewer than wanted are
/// started, which is at most four for each core.
pub fn start_threads(wanted: Option<usize>) -> Result<Option<usize>, Fault> {
    let most = MOST_PER_CORE * available_parallelism().map_or(1, NonZero::get);
    let n = wanted.map_or(0, |wanted| wanted.min(most));
    rayon::ThreadPoolBuilder::new().num_threads(n).build_global().map_err(|error| {
        let fault = Fault::data(format!("the threads cannot be started: {error}"));
        fault.with_remedy("take fewer (`threads`), or allow more processes or memory (ulimit -u, ulimit -v)")
    })?;
    Ok(wanted.filter(|wanted| *wanted > most).map(|_| most))
}
