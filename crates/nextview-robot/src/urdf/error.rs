use std::fmt;

/// Reasons why a URDF is not an arm: all faults that can be found at once.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", listed(faults))]
pub struct UrdfError {
    /// The faults in file order, at least one.
    pub faults: Vec<UrdfFault>,
}

/// One fault of a URDF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UrdfFault {
    /// The line of the element, counted from 1; `None` for a fault in the options or the whole tree.
    pub line: Option<u32>,
    /// The element, such as `joint "elbow"`, or the option.
    pub place: String,
    /// The fault, the value, and the expected value.
    pub problem: String,
}

impl UrdfFault {
    pub(super) fn new(line: Option<u32>, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { line, place: place.into(), problem: problem.into() }
    }
}

impl fmt::Display for UrdfFault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}, ")?;
        }
        write!(f, "{}: {}", self.place, self.problem)
    }
}

impl From<UrdfFault> for UrdfError {
    fn from(fault: UrdfFault) -> Self {
        Self { faults: vec![fault] }
    }
}

/// The faults as a text, one per line.
fn listed(faults: &[UrdfFault]) -> String {
    faults.iter().map(UrdfFault::to_string).collect::<Vec<_>>().join("\n")
}
