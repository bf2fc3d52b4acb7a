//! The parts of the program `nextview` that other programs and tests can call.

pub mod report;
