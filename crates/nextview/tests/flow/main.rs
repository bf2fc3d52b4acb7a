//! The flow against slow and obvious solvers, and against what the authors' code measured.

#![allow(clippy::unwrap_used, reason = "clippy allows it in test functions, not in their helpers")]

mod cover;
mod golden;
mod network;
mod oracles;
