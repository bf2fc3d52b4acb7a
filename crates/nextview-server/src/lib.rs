//! An HTTP server for scans with any camera: clients post frames and receive the next views.
//!
//! [`nextview_scan::LiveScan`] implements the scans; this crate adds HTTP: routes, bodies, access control,
//! and limits on requests. Every frame is on the disk before it is acknowledged, and a killed server resumes
//! all scans. Start with [`serve`]; `docs/server.md` describes the routes.

mod access;
mod answers;
mod app;
mod body;
mod connections;
mod frames;
#[cfg(fuzzing)]
pub mod fuzzing;
mod guard;
mod json;
mod limits;
mod openapi;
mod refusal;
mod room;
mod routes;
mod scans;
mod serve;

pub use limits::Limits;
pub use openapi::openapi;
pub use serve::{ServerConfig, Started, serve};
