//! Whole scans in the simulator.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod cancel;
mod closed_loop;
mod common;
mod inspection;
mod noise;
mod registration;
mod truth;
mod turned;
mod unknown_object;
