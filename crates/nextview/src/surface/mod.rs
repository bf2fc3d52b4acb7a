//! The scanned surface: the shape of the object, from all measured frames.
//!
//! Start with [`DistanceField`]: it integrates the frames of a scan and gives a [`SurfaceMesh`], made by
//! [`surface_nets`], which meshes any signed distance. [`frame_points`] gives the measured points of a frame
//! with normals and colours, [`downsample`] thins those of many frames, [`fit_normals`] smooths their
//! normals, [`take_colors`] transfers their colours to a mesh; [`write_mesh`], [`write_cloud`] and
//! [`write_points`] write PLY. Planning reads none of this. Not here: filling of holes.

mod clear_depth;
mod cloud;
mod cloud_point;
mod colors;
mod distance_field;
mod frame_surface;
mod normals;
mod ply;
mod specks;
mod surface_mesh;
mod surface_nets;
mod tangent_plane;

pub use cloud::downsample;
pub use cloud_point::{CloudPoint, frame_points};
pub use colors::take_colors;
pub use distance_field::DistanceField;
pub use normals::fit_normals;
pub use ply::{write_cloud, write_mesh, write_points};
pub use surface_mesh::SurfaceMesh;
pub use surface_nets::surface_nets;
