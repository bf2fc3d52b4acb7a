//! The finished model of a scan, from depth frames with poses.
//!
//! Start with [`DistanceField`]: it integrates the frames of a scan and returns a [`SurfaceMesh`], made by
//! [`surface_nets`], which meshes any signed distance, or a [`WatertightMesh`], closed where nothing was
//! measured. [`fused_cloud`] fuses the [points of many frames](nextview::surface::frame_points) into one
//! cloud. [`take_nearest`] transfers their colours to a mesh; [`write_mesh`], [`write_cloud`] and
//! [`write_points`] write PLY. [`texture_mesh`] textures a mesh from photos, and [`write_obj`] writes it.
//!
//! Like [`nextview`], which plans, this crate computes: it opens no file and prints nothing.

mod clear_depth;
mod depth_tiles;
mod diffusion;
mod distance_field;
mod frame_surface;
mod fused_cloud;
mod nearest_point;
mod ply;
mod specks;
mod surface_mesh;
mod surface_nets;
#[cfg(test)]
mod synthetic_frames;
mod texture;
mod watertight;
mod well_composed;

pub use distance_field::DistanceField;
pub use fused_cloud::fused_cloud;
pub use nearest_point::take_nearest;
pub use ply::{write_cloud, write_mesh, write_points};
pub use surface_mesh::SurfaceMesh;
pub use surface_nets::surface_nets;
pub use texture::{Photo, TexturedMesh, texture_mesh, write_mtl, write_obj};
pub use watertight::{Floor, WatertightMesh};
