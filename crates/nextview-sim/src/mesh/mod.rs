//! Triangle meshes, the files they come in, and points on their surface.
//!
//! Start with [`TriangleMesh`].

mod sample;
mod triangle_mesh;

pub use sample::sample_surface;
pub use triangle_mesh::TriangleMesh;
