//! The parsers without files, for `fuzz/` only.

use super::raw::RawMesh;
use super::{TriangleMesh, gltf, obj, off, ply, stl};
use crate::SimError;

/// Parses the mesh in these bytes; every file they name holds `beside`.
pub fn parse(extension: &str, bytes: &[u8], beside: &[u8]) -> Result<TriangleMesh, SimError> {
    let raw: RawMesh = match extension {
        "ply" => ply::parse(bytes),
        "obj" => obj::parse(bytes, &|_| Ok(beside.to_vec())),
        "stl" => stl::parse(bytes),
        "off" => off::parse(bytes),
        _ => gltf::parse(bytes, &|_| Ok(beside.to_vec())),
    }?;
    Ok(raw.check((bytes.len() + beside.len()) as u64)?.0)
}

/// Parses a PLY file and returns its number of points.
pub fn parse_points(bytes: &[u8]) -> Result<usize, SimError> {
    Ok(ply::parse_points(bytes)?.0.len())
}
