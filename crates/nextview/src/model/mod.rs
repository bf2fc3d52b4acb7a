//! The scanned surface: what the measured frames together say about the object's shape.
//!
//! Start with [`DistanceField`]: it takes in the frames of a scan and gives a [`SurfaceMesh`], made by
//! [`surface_nets`], which meshes any signed distance. [`downsample`] thins the plain points; [`write_mesh`] and
//! [`write_points`] write PLY. Planning reads none of this. Not here: filling of holes, colours.

mod cloud;
mod distance_field;
mod frame_surface;
mod ply;
mod surface_nets;

pub use cloud::downsample;
pub use distance_field::DistanceField;
pub use ply::{write_mesh, write_points};
pub use surface_nets::{SurfaceMesh, surface_nets};
