//! Files that a C++ program reads with one call: little-endian numbers without a header.
//!
//! | file | content |
//! |---|---|
//! | `mesh{0,1,2}.bin` | number of vertices and triangles (i32), vertices (f32 x y z), triangles (i32 a b c) |
//! | `poses.f64`, `views5000.f64` | 4 x 4 matrices `world_from_camera`, row by row |
//! | `cloud{A,B}_{0..9}.f32` | points x y z, metres, world |
//! | `depth_{0..9}.f32` | depths of the object alone, metres, row by row, 0 for none |
//! | `depth.png`, `mesh2.ply` | the first of these images, and the finest mesh, as files of our program |
//! | `known.f32`, `points.f32`, `motion.f64` | points x y z and normals x y z to [align](crate::alignment): where the surface is known, those of another image where they belong, and the motion that takes these off |
//! | `network_{small,large}.bin` | see [`RayNetwork`](crate::network::RayNetwork) |

use crate::Outcome;
use glam::{DMat3, DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::registration::SurfacePoint;
use nextview::sensor::{Depth, DepthImage};
use nextview_sim::mesh::TriangleMesh;
use std::path::Path;

/// Writes a mesh.
///
/// # Errors
/// As everywhere in this module: if the file cannot be read or written, with its name.
pub fn write_mesh(path: &Path, mesh: &TriangleMesh) -> Outcome<()> {
    let (vertices, triangles) = (mesh.vertices(), mesh.triangles());
    let mut bytes = Vec::new();
    [vertices.len(), triangles.len()].iter().for_each(|&n| bytes.extend((n as i32).to_le_bytes()));
    let coordinates = vertices.iter().flat_map(|v| v.as_vec3().to_array());
    coordinates.for_each(|x| bytes.extend(x.to_le_bytes()));
    triangles.iter().flatten().for_each(|&i| bytes.extend((i as i32).to_le_bytes()));
    write(path, &bytes)
}

/// Reads a mesh.
///
/// # Errors
/// If the file is not a mesh.
pub fn read_mesh(path: &Path) -> Outcome<TriangleMesh> {
    let bytes = read(path)?;
    let words: Vec<[u8; 4]> = bytes.chunks_exact(4).filter_map(|word| word.try_into().ok()).collect();
    let &[n_vertices, n_triangles, ..] = words.as_slice() else {
        return Err(format!("{}: too short for a mesh", path.display()).into());
    };
    let [n_vertices, n_triangles] = [n_vertices, n_triangles].map(|n| i32::from_le_bytes(n).max(0) as usize);
    let (coordinates, corners) = words[2..]
        .split_at_checked(3 * n_vertices)
        .filter(|(_, corners)| corners.len() == 3 * n_triangles)
        .ok_or_else(|| {
            format!(
                "{}: {} words for {n_vertices} vertices and {n_triangles} triangles",
                path.display(),
                words.len()
            )
        })?;
    let vertices = coordinates
        .chunks_exact(3)
        .map(|v| DVec3::from_slice(&[0, 1, 2].map(|i| f32::from_le_bytes(v[i]) as f64)));
    let triangles = corners.chunks_exact(3).map(|t| [0, 1, 2].map(|i| u32::from_le_bytes(t[i])));
    Ok(TriangleMesh::new(vertices.collect(), triangles.collect())?)
}

/// Writes a cloud.
///
/// # Errors
/// If the file cannot be written.
pub fn write_cloud(path: &Path, points: &[DVec3]) -> Outcome<()> {
    let coordinates = points.iter().flat_map(|p| p.as_vec3().to_array());
    write(path, &coordinates.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

/// Writes points with normals.
///
/// # Errors
/// If the file cannot be written.
pub fn write_surface(path: &Path, points: &[SurfacePoint]) -> Outcome<()> {
    let numbers = points.iter().flat_map(|p| [p.position, p.normal]).flat_map(|v| v.as_vec3().to_array());
    write(path, &numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

/// Writes a depth image.
///
/// # Errors
/// If the file cannot be written.
pub fn write_depth(path: &Path, image: &DepthImage) -> Outcome<()> {
    let metres = |depth| if let Depth::Surface(metres) = depth { metres } else { 0.0 };
    write(path, &image.pixels().map(metres).flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

/// Reads a cloud.
///
/// # Errors
/// If the file cannot be read.
pub fn read_cloud(path: &Path) -> Outcome<Vec<DVec3>> {
    let bytes = read(path)?;
    let numbers: Vec<f64> =
        bytes.chunks_exact(4).filter_map(|x| Some(f32::from_le_bytes(x.try_into().ok()?) as f64)).collect();
    Ok(numbers.chunks_exact(3).map(DVec3::from_slice).collect())
}

/// Writes poses.
///
/// # Errors
/// If the file cannot be written.
pub fn write_poses(path: &Path, poses: &[Pose]) -> Outcome<()> {
    let rows = |pose: &Pose| {
        let (rotation, position) = (pose.rotation_matrix(), pose.translation());
        let row = |i: usize| rotation.row(i).extend(position[i]).to_array();
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    };
    let numbers = poses.iter().flat_map(rows).flatten();
    write(path, &numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
}

/// Reads poses.
///
/// # Errors
/// If the file cannot be read or holds an invalid pose.
pub fn read_poses(path: &Path) -> Outcome<Vec<Pose>> {
    let bytes = read(path)?;
    let numbers: Vec<f64> =
        bytes.chunks_exact(8).filter_map(|x| Some(f64::from_le_bytes(x.try_into().ok()?))).collect();
    let pose = |m: &[f64]| {
        let rotation = DMat3::from_cols_array(&[m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]]);
        // Rows were read as columns: the transpose is the rotation.
        Ok(Pose::new(DQuat::from_mat3(&rotation.transpose()), DVec3::new(m[3], m[7], m[11]))?)
    };
    numbers.chunks_exact(16).map(pose).collect()
}

fn read(path: &Path) -> Outcome<Vec<u8>> {
    std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()).into())
}

pub(crate) fn write(path: &Path, bytes: &[u8]) -> Outcome<()> {
    std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
}
