//! The program `nextview`: its options, its progress, and what it prints.
//!
//! It words faults, draws progress and holds no logic that another front end would need: scans are run by
//! [`nextview_scan`], campaigns by [`nextview_campaign`], pages are made by [`nextview_report`]. Data goes to
//! stdout, messages to stderr. Exit codes: 0 done, 1 bad data or a failing system, 2 bad usage, 130
//! interrupted.

pub mod commands;
mod failure;
mod flags;
mod interrupt;
mod progress;
mod stdout;

pub use failure::Failure;
