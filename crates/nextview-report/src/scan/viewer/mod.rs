//! The 3D view of a scan: measured points, cameras, the path between them.

mod cloud;
mod scene;

pub(super) use cloud::note;
pub(super) use scene::json as scene;

/// The script that draws the scene and lets the reader turn it.
pub(super) const SCRIPT: &str = include_str!("viewer.js");
