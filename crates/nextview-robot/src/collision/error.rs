use std::fmt;

/// Reasons why a cell cannot be checked; all faults at once.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct CellError {
    /// One entry per fault: the place, the value and the expected value.
    pub faults: Vec<String>,
}

impl fmt::Display for CellError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.faults.join("; "))
    }
}

impl CellError {
    pub(super) fn unless_empty(faults: Vec<String>) -> Result<(), Self> {
        if faults.is_empty() { Ok(()) } else { Err(Self { faults }) }
    }
}
