//! Writes PLY in the binary little-endian form that common viewers read, with single precision. Positions
//! have double precision if one is 32 m or more from the origin along an axis, where single precision
//! resolves 4 micrometres.
//!
//! Vertices have the columns `nx ny nz` if any of them has a normal, `red green blue` if any has a colour,
//! `error_m` if any has an expected error, and `filled` in a closed mesh. PLY has no missing values: a vertex
//! without normal has 0 0 0, which viewers draw unshaded and which, unlike NaN, every reader accepts; one
//! without colour is black, and an unknown error is 0.

use glam::DVec3;
use nextview::Error;
use nextview::surface::CloudPoint;
use std::io::{BufWriter, Write};

/// Writes points, metres.
///
/// The points are iterated twice, to count and to write them, so they need not be in memory.
pub fn write_points<I: Iterator<Item = DVec3>>(
    writer: impl Write,
    points: impl Fn() -> I,
) -> Result<(), Error> {
    let mut writer = BufWriter::new(writer);
    let columns = VertexColumns { is_far: points().any(is_far), ..VertexColumns::default() };
    columns.write_header(&mut writer, points().count(), None)?;
    points().try_for_each(|point| columns.write_vertex(&mut writer, &point.into()))?;
    Ok(writer.flush()?)
}

/// Writes points with their normals and colours, metres.
pub fn write_cloud(writer: impl Write, points: &[CloudPoint]) -> Result<(), Error> {
    let mut writer = BufWriter::new(writer);
    let columns = VertexColumns::of(points);
    columns.write_header(&mut writer, points.len(), None)?;
    points.iter().try_for_each(|point| columns.write_vertex(&mut writer, point))?;
    Ok(writer.flush()?)
}

/// Writes a mesh, metres: vertices, such as those of [`SurfaceMesh::points`](super::SurfaceMesh::points), and
/// triangles of three vertex indices each. With `is_filled`, one value per vertex, it adds a column `filled`:
/// 1 for filled-in vertices and 0 for measured ones. Panics if `is_filled` has another length.
pub fn write_mesh(
    writer: impl Write,
    vertices: &[CloudPoint],
    is_filled: Option<&[bool]>,
    triangles: &[[u32; 3]],
) -> Result<(), Error> {
    assert!(is_filled.is_none_or(|is_filled| is_filled.len() == vertices.len()), "one for each vertex");
    let mut writer = BufWriter::new(writer);
    let columns = VertexColumns { filled: is_filled.is_some(), ..VertexColumns::of(vertices) };
    columns.write_header(&mut writer, vertices.len(), Some(triangles.len()))?;
    for (i, vertex) in vertices.iter().enumerate() {
        columns.write_vertex(&mut writer, vertex)?;
        if let Some(is_filled) = is_filled {
            writer.write_all(&[u8::from(is_filled[i])])?;
        }
    }
    for triangle in triangles {
        writer.write_all(&[3])?;
        for index in triangle {
            writer.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(writer.flush()?)
}

/// The columns of every vertex, apart from its position.
#[derive(Clone, Copy, Default)]
struct VertexColumns {
    /// Whether positions are in double precision.
    is_far: bool,
    normal: bool,
    color: bool,
    error: bool,
    filled: bool,
}

impl VertexColumns {
    fn of(points: &[CloudPoint]) -> Self {
        Self {
            is_far: points.iter().any(|point| is_far(point.position)),
            normal: points.iter().any(|point| point.normal.is_some()),
            color: points.iter().any(|point| point.color.is_some()),
            error: points.iter().any(|point| point.error.is_some()),
            filled: false,
        }
    }

    fn write_header(
        self,
        writer: &mut impl Write,
        n_vertices: usize,
        n_faces: Option<usize>,
    ) -> Result<(), Error> {
        writeln!(writer, "ply\nformat binary_little_endian 1.0\nelement vertex {n_vertices}")?;
        let number = if self.is_far { "double" } else { "float" };
        writeln!(writer, "property {number} x\nproperty {number} y\nproperty {number} z")?;
        if self.normal {
            writeln!(writer, "property float nx\nproperty float ny\nproperty float nz")?;
        }
        if self.color {
            writeln!(writer, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
        }
        if self.error {
            writeln!(writer, "property float error_m")?;
        }
        if self.filled {
            writeln!(writer, "property uchar filled")?;
        }
        if let Some(n_faces) = n_faces {
            writeln!(writer, "element face {n_faces}\nproperty list uchar uint vertex_indices")?;
        }
        Ok(writeln!(writer, "end_header")?)
    }

    fn write_vertex(self, writer: &mut impl Write, point: &CloudPoint) -> Result<(), Error> {
        match self.is_far {
            true => point.position.to_array().iter().try_for_each(|x| writer.write_all(&x.to_le_bytes()))?,
            false => write_vector(writer, point.position)?,
        }
        if self.normal {
            write_vector(writer, point.normal.unwrap_or_default())?;
        }
        if self.color {
            writer.write_all(&point.color.unwrap_or_default())?;
        }
        if self.error {
            writer.write_all(&point.error.unwrap_or_default().to_le_bytes())?;
        }
        Ok(())
    }
}

/// Whether single precision would resolve less than 4 micrometres.
fn is_far(position: DVec3) -> bool {
    position.abs().max_element() >= 32.0
}

fn write_vector(writer: &mut impl Write, vector: DVec3) -> Result<(), Error> {
    for coordinate in vector.as_vec3().to_array() {
        writer.write_all(&coordinate.to_le_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: CloudPoint =
        CloudPoint { position: DVec3::new(0.5, -1.0, 2.0), normal: None, color: None, error: None };

    fn split(bytes: &[u8]) -> (&str, &[u8]) {
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        (std::str::from_utf8(&bytes[..at]).unwrap(), &bytes[at..])
    }

    #[test]
    fn a_mesh_is_a_header_and_its_numbers() {
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, &[POINT; 3], None, &[[0, 1, 258]]).unwrap();
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
    fn normals_and_colours_are_written_where_any_point_has_one() {
        let full = CloudPoint { normal: Some(DVec3::new(0.0, 0.0, 2.0)), color: Some([1, 2, 3]), ..POINT };
        let mut bytes = Vec::new();
        write_cloud(&mut bytes, &[POINT, full]).unwrap();
        let (header, body) = split(&bytes);
        assert!(header.contains(
            "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
        ));
        let xyz = [0, 0, 0, 63, 0, 0, 128, 191, 0, 0, 0, 64];
        assert_eq!(body[..27], [&xyz[..], &[0; 12], &[0, 0, 0]].concat());
        assert_eq!(body[27..], [&xyz[..], &[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 64], &[1, 2, 3]].concat());
        let [mut cloud, mut points] = [Vec::new(), Vec::new()];
        write_cloud(&mut cloud, &[POINT; 2]).unwrap();
        write_points(&mut points, || [POINT.position; 2].into_iter()).unwrap();
        assert_eq!(cloud, points);
    }

    #[test]
    fn what_was_filled_in_is_the_last_column() {
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, &[POINT; 2], Some(&[false, true]), &[]).unwrap();
        let (header, body) = split(&bytes);
        assert!(header.contains("property float z\nproperty uchar filled\nelement face 0\n"));
        assert_eq!((body.len(), body[12], body[25]), (26, 0, 1));
    }

    #[test]
    fn nothing_is_a_valid_file() {
        let (mut points, mut mesh) = (Vec::new(), Vec::new());
        write_cloud(&mut points, &[]).unwrap();
        write_mesh(&mut mesh, &[], None, &[]).unwrap();
        assert!(split(&points).0.contains("element vertex 0\n") && split(&points).1.is_empty());
        assert!(split(&mesh).0.contains("element face 0\n") && split(&mesh).1.is_empty());
    }

    #[test]
    fn a_writer_that_fails_is_an_error() {
        let mut too_short = [0_u8; 100];
        let error = write_points(too_short.as_mut_slice(), || [DVec3::ZERO; 9].into_iter()).unwrap_err();
        assert!(matches!(error, Error::Io(_)), "{error}");
    }
}
