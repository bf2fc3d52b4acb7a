//! Writers of PLY, the binary little-endian form with single precision that common viewers read.

use super::SurfaceMesh;
use crate::Error;
use glam::DVec3;
use std::io::{BufWriter, Write};

/// Writes points, metres.
pub fn write_points(writer: impl Write, points: &[DVec3]) -> Result<(), Error> {
    let mut writer = BufWriter::new(writer);
    write_header(&mut writer, points.len(), None)?;
    write_vertices(&mut writer, points)?;
    Ok(writer.flush()?)
}

/// Writes a mesh, metres.
pub fn write_mesh(writer: impl Write, mesh: &SurfaceMesh) -> Result<(), Error> {
    let mut writer = BufWriter::new(writer);
    write_header(&mut writer, mesh.vertices.len(), Some(mesh.triangles.len()))?;
    write_vertices(&mut writer, &mesh.vertices)?;
    for triangle in &mesh.triangles {
        writer.write_all(&[3])?;
        for index in triangle {
            writer.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(writer.flush()?)
}

fn write_header(writer: &mut impl Write, n_vertices: usize, n_faces: Option<usize>) -> Result<(), Error> {
    writeln!(writer, "ply\nformat binary_little_endian 1.0\nelement vertex {n_vertices}")?;
    writeln!(writer, "property float x\nproperty float y\nproperty float z")?;
    if let Some(n_faces) = n_faces {
        writeln!(writer, "element face {n_faces}\nproperty list uchar uint vertex_indices")?;
    }
    Ok(writeln!(writer, "end_header")?)
}

fn write_vertices(writer: &mut impl Write, points: &[DVec3]) -> Result<(), Error> {
    for coordinate in points.iter().flat_map(|point| point.as_vec3().to_array()) {
        writer.write_all(&coordinate.to_le_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(bytes: &[u8]) -> (&str, &[u8]) {
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        (std::str::from_utf8(&bytes[..at]).unwrap(), &bytes[at..])
    }

    #[test]
    fn a_mesh_is_a_header_and_its_numbers() {
        let mesh =
            SurfaceMesh { vertices: vec![DVec3::new(0.5, -1.0, 2.0); 3], triangles: vec![[0, 1, 258]] };
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, &mesh).unwrap();
        let (header, body) = split(&bytes);
        assert_eq!(
            header,
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n"
        );
        assert_eq!(body.len(), 3 * 12 + 13);
        assert_eq!(body[..12], [0, 0, 0, 63, 0, 0, 128, 191, 0, 0, 0, 64], "0.5, -1, 2");
        assert_eq!(body[36..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1, 0, 0]);
    }

    #[test]
    fn nothing_is_a_valid_file() {
        let (mut points, mut mesh) = (Vec::new(), Vec::new());
        write_points(&mut points, &[]).unwrap();
        write_mesh(&mut mesh, &SurfaceMesh::default()).unwrap();
        assert!(split(&points).0.contains("element vertex 0\n") && split(&points).1.is_empty());
        assert!(split(&mesh).0.contains("element face 0\n") && split(&mesh).1.is_empty());
    }

    #[test]
    fn a_writer_that_fails_is_an_error() {
        let mut too_short = [0_u8; 100];
        let error = write_points(too_short.as_mut_slice(), &[DVec3::ZERO; 9]).unwrap_err();
        assert!(matches!(error, Error::Io(_)), "{error}");
    }
}
