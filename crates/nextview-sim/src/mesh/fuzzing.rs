//! The parsers without files, for `fuzz/` alone.

use super::raw::RawMesh;
use super::{TriangleMesh, gltf, obj, off, ply, stl};
use crate::SimError;

/// The mesh in these bytes; every file that they name holds `beside`.
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

/// Number of points in a PLY file.
pub fn parse_points(bytes: &[u8]) -> Result<usize, SimError> {
    Ok(ply::parse_points(bytes)?.0.len())
}
