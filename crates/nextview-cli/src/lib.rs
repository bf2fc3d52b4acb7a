//! The program `nextview`: its commands, its configuration, and what it writes.
//!
//! It opens files, prints and reads the clock, which the library never does, and contains no planning logic. Data goes to
//! stdout, messages to stderr. Exit codes: 0 done, 1 bad data or a failing system, 2 bad usage.

mod bench;
pub mod commands;
mod dataset;
mod failure;
mod files;
pub mod report;
mod scan;
mod stdout;
mod study;

pub use failure::Failure;
