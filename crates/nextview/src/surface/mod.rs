//! The scanned surface: the object's shape from all measured frames.
//!
//! Start with [`DistanceField`]: it integrates the frames of a scan and returns a [`SurfaceMesh`], made by
//! [`surface_nets`], which meshes any signed distance, or a [`WatertightMesh`], closed where nothing was
//! measured. [`frame_points`] returns the measured points of a frame with normals and colours.
//! [`fused_cloud`] fuses the points of many frames, using [`downsample`] to thin them and [`fit_normals`] to
//! smooth their normals. [`take_nearest`] transfers their colours to a mesh; [`write_mesh`], [`write_cloud`]
//! and [`write_points`] write PLY. [`texture_mesh`] textures a mesh from photos, and [`write_obj`] writes it.
//! [`MeasuredCells`] reports the accuracy of the surface, [`SurfaceLooks`] the number of looks at it;
//! planning reads nothing else from this module.

mod clear_depth;
mod cloud;
mod cloud_point;

mod depth_tiles;
mod diffusion;
mod distance_field;
mod frame_surface;
mod fused_cloud;
mod looks;
mod measured_cells;
mod nearest_point;
mod normals;
mod ply;
mod specks;
mod surface_mesh;
mod surface_nets;
mod tangent_plane;
mod texture;
mod watertight;
mod well_composed;

pub use cloud::downsample;
pub use cloud_point::{CloudPoint, frame_points};
pub use distance_field::DistanceField;
pub use fused_cloud::fused_cloud;
pub use looks::{LooksGoal, SurfaceLooks};
pub use measured_cells::MeasuredCells;
pub use nearest_point::take_nearest;
pub use normals::fit_normals;
pub use ply::{write_cloud, write_mesh, write_points};
pub use surface_mesh::SurfaceMesh;
pub use surface_nets::surface_nets;
pub use texture::{Photo, TexturedMesh, texture_mesh, write_mtl, write_obj};
pub use watertight::{Floor, WatertightMesh};
