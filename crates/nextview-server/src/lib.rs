//! An HTTP server for scans with any camera: clients post frames and get the next views.
//!
//! Scans are those of [`nextview_scan::LiveScan`]; what is here is HTTP: routes, bodies, who may ask, and
//! limits against too many requests. Every frame is on the disk before it is acknowledged, and a server that
//! was killed resumes all scans. Start with [`serve`]; `docs/server.md` describes the routes.

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
