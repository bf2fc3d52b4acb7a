use std::io;

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
