use std::fmt;

/// The reasons why a cell cannot be checked; all faults at once.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct CellError {
    /// What, where, the value and what would be right, one entry for each fault.
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
