//! Wavefront OBJ: positions and faces; everything else is skipped.

use super::raw::RawMesh;
use super::text::{Line, lines, shown};
use crate::SimError;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SimError> {
    let mut mesh = RawMesh::default();
    for line in lines(bytes, 1) {
        match line.keyword() {
            b"v" => mesh.vertices.push(line.point(1)?),
            b"f" => {
                let corners: Result<Vec<u32>, SimError> =
                    line.words()[1..].iter().map(|word| corner(&line, word, mesh.vertices.len())).collect();
                mesh.push_polygon(&corners?);
            }
            _ => {}
        }
    }
    Ok(mesh)
}

/// The vertex of a corner such as `7`, `7/2`, `7/2/3` or `-1`. Vertices count from 1, or backwards from the
/// last one before the face.
fn corner(line: &Line, word: &[u8], n_vertices: usize) -> Result<u32, SimError> {
    let number = word.split(|&byte| byte == b'/').next().unwrap_or_default();
    let stated: i64 = str::from_utf8(number)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| line.error(format!("{:?} is not a vertex number", shown(word))))?;
    let index = if stated > 0 { stated - 1 } else { (n_vertices as i64).saturating_add(stated) };
    if stated == 0 || index < 0 || index >= n_vertices as i64 {
        let problem =
            format!("refers to vertex {stated}, but {n_vertices} vertices are defined before this face");
        return Err(line.error(problem));
    }
    u32::try_from(index).map_err(|_| line.error(format!("vertex number {stated} is too large")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn reads_every_form_of_a_face() {
        let text = b"# cube side\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0 # corner\r\nv 0 1 0\n\
            vt 0 0\ng side\nf 1 2 3 4\nf 1/1 2/1 3/1\nf -4//1 -3//1 -1//1\nf 1 2\n";
        let mesh = parse(text).unwrap();
        assert_eq!(mesh.vertices[2], DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 3]]);
        assert_eq!(mesh.n_too_small, 1);
    }

    #[test]
    fn says_where_it_is_broken() {
        let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error("v 0 0\n"), "line 1: has 3 words, expected a coordinate as word 4");
        assert_eq!(error("\nv 0 zero 0\n"), "line 2: \"zero\" is not a coordinate");
        assert_eq!(error("v 0 0 0\nf a 1 1"), "line 2: \"a\" is not a vertex number");
        for bad in ["0", "2", "-2", "9223372036854775807", "-9223372036854775808"] {
            assert!(error(&format!("v 0 0 0\nf 1 1 {bad}")).contains(bad));
        }
    }
}
