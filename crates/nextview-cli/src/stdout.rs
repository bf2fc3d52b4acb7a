//! The output of the program.

use crate::Failure;
use std::io::{self, ErrorKind, Write};

/// Writes to stdout. A reader that stops early, such as `head`, is not a failure; a full disk behind a
/// redirection is.
pub(crate) fn print(text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_ref()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::data(format!("stdout: cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}
