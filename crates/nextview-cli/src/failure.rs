use crate::flags;
use nextview_scan::{Fault, FaultKind, Faults};
use std::fmt;

/// The reason why a command failed, worded for users of the program.
#[derive(Debug)]
pub struct Failure(Faults);

impl Failure {
    /// An invalid request by the user: exit code 2.
    pub fn usage(message: impl fmt::Display) -> Self {
        Fault::request(message).into()
    }

    /// A fault of a file or the system: exit code 1.
    pub fn data(message: impl fmt::Display) -> Self {
        Fault::data(message).into()
    }

    /// Sets the hint.
    pub fn with_hint(self, hint: impl fmt::Display) -> Self {
        Self(self.0.map(|fault| fault.with_remedy(&hint)))
    }

    /// 1 for bad data or a failing system, 2 for bad usage.
    pub fn exit_code(&self) -> u8 {
        if self.0.iter().any(|fault| fault.kind == FaultKind::Data) { 1 } else { 2 }
    }
}

impl fmt::Display for Failure {
    /// Writes every fault, each with its hint, in terms of the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.0.iter().enumerate() {
            // Keys in a configuration file stay keys.
            let is_in_file = fault.key.is_some() && fault.place.is_some();
            let word = |text: &str| if is_in_file { text.replace('`', "") } else { flags::word(text) };
            let place = fault.place.iter().map(|place| format!("{place}: ")).collect::<String>();
            write!(f, "{}error: {place}{}", if i > 0 { "\n" } else { "" }, word(&fault.message))?;
            fault.remedy.iter().try_for_each(|remedy| write!(f, "\nhint: {}", word(remedy)))?;
        }
        Ok(())
    }
}

impl<E: Into<Faults>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}
