//! The program `nextview`: its options, its progress, and its output.
//!
//! It words faults, draws progress and contains no logic that another front end would need: [`nextview_scan`]
//! runs scans, [`nextview_campaign`] campaigns, and [`nextview_report`] makes pages. Data goes to stdout,
//! messages to stderr. Exit codes: 0 success, 1 bad data or a system failure, 2 bad usage, 130 interrupted.

pub mod commands;
mod failure;
mod flags;
mod interrupt;
mod progress;
mod stdout;

pub use failure::Failure;
