//! Triangle meshes, their files, and points on their surface.
//!
//! Start with [`TriangleMesh`], or with [`load`] for a file. Its colours are an [`Appearance`]. The parsers
//! are our own: they are short, name the line or byte where a file is broken, and never reserve memory based
//! on a header alone.

mod appearance;
mod file;
#[cfg(fuzzing)]
pub mod fuzzing;
mod gltf;
mod image;
mod limit;
mod mtl;
mod obj;
mod off;
mod ply;
mod raw;
mod sample;
pub(crate) mod srgb;
mod stl;
#[cfg(test)]
mod tests;
mod text;
mod triangle_mesh;
mod unit;

pub use appearance::{Appearance, Face, Material};
pub use file::{FileMesh, load, load_points};
#[cfg(test)]
pub(crate) use sample::N_SAMPLES;
pub use sample::sample_surface;
pub(crate) use sample::surface_samples;
pub use triangle_mesh::TriangleMesh;
pub use unit::{Scaling, Unit, UnitSource};
