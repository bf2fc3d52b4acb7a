//! One scan through the library's public face.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod common;
mod configuration;
mod far;
mod journal;
mod live;
mod measures;
mod quality;
mod resume;
mod robot;
mod run;
mod simulation;
mod watertight;
