//! Writes Wavefront OBJ and its material library.

use super::textured_mesh::TexturedMesh;
use nextview::Error;
use std::io::{BufWriter, Write};

/// Writes the mesh as OBJ, in metres. `material` is the name of its material and, with the extension `mtl`,
/// of the file next to it written by [`write_mtl`]. Fails if the name does not fit on one line.
pub fn write_obj(writer: impl Write, mesh: &TexturedMesh, material: &str) -> Result<(), Error> {
    check_name("name of the material", material)?;
    let mut writer = BufWriter::new(writer);
    writeln!(writer, "mtllib {material}.mtl")?;
    for vertex in &mesh.vertices {
        writeln!(writer, "v {} {} {}", vertex.x, vertex.y, vertex.z)?;
    }
    for point in &mesh.texture_points {
        writeln!(writer, "vt {:.7} {:.7}", point.x, point.y)?;
    }
    writeln!(writer, "usemtl {material}")?;
    for (triangle, texture) in mesh.triangles.iter().zip(&mesh.texture_triangles) {
        let [a, b, c] =
            [0, 1, 2].map(|i| format!("{}/{}", u64::from(triangle[i]) + 1, u64::from(texture[i]) + 1));
        writeln!(writer, "f {a} {b} {c}")?;
    }
    Ok(writer.flush()?)
}

/// Writes the material library of an OBJ file: one material of this name, with an image file next to it.
/// Fails if a name does not fit on one line.
pub fn write_mtl(mut writer: impl Write, material: &str, texture_file_name: &str) -> Result<(), Error> {
    check_name("name of the material", material)?;
    check_name("name of the texture file", texture_file_name)?;
    let text =
        format!("newmtl {material}\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {texture_file_name}\n");
    Ok(writer.write_all(text.as_bytes())?)
}

fn check_name(what: &'static str, name: &str) -> Result<(), Error> {
    if name.is_empty() || name.contains(['#', '\n', '\r']) {
        return Err(Error::invalid(what, format!("{name:?}"), "a name without line breaks and #"));
    }
    Ok(())
}
