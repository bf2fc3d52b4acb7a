//! OFF in text form, with or without colours and normals.

use super::raw::RawMesh;
use super::text::{NumberedLine, lines, shown};
use crate::SimError;
use nextview::text::plain;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SimError> {
    let text = plain(bytes)?;
    let mut lines = lines(&text, 1);
    let end = || SimError::format("end of the file", "not all vertices and faces are listed");
    let mut header = lines.next().ok_or_else(end)?.without_prefix(&[b"OFF", b"COFF", b"NOFF", b"CNOFF"]);
    match header.words().first() {
        None => header = lines.next().ok_or_else(end)?,
        Some(word) if word[0].is_ascii_digit() => {}
        Some(word) if word.eq_ignore_ascii_case(b"BINARY") => {
            return Err(header.error("is binary OFF, which is not supported; convert the file to PLY"));
        }
        Some(word) => return Err(header.error(format!("starts with {:?}, expected OFF", shown(word)))),
    }
    let n_vertices = count(&header, 0, "the number of vertices", bytes.len())?;
    let n_faces = count(&header, 1, "the number of faces", bytes.len())?;

    let mut mesh = RawMesh::default();
    for _ in 0..n_vertices {
        mesh.vertices.push(lines.next().ok_or_else(end)?.point(0)?);
    }
    for _ in 0..n_faces {
        let line = lines.next().ok_or_else(end)?;
        mesh.push_polygon(&corners(&line, n_vertices)?);
    }
    Ok(mesh)
}

/// A number of lines, which cannot exceed the number of bytes.
fn count(line: &NumberedLine, word: usize, what: &str, n_bytes: usize) -> Result<usize, SimError> {
    let n: usize = line.number(word, what)?;
    if n > n_bytes {
        return Err(line.error(format!("{what} is {n}, but the file has only {n_bytes} bytes")));
    }
    Ok(n)
}

fn corners(line: &NumberedLine, n_vertices: usize) -> Result<Vec<u32>, SimError> {
    let n: usize = line.number(0, "a number of corners")?;
    if n >= line.words().len() {
        return Err(line.error(format!("states {n} corners but lists {}", line.words().len() - 1)));
    }
    (1..=n)
        .map(|i| match line.number(i, "a vertex number")? {
            index if (index as usize) < n_vertices => Ok(index),
            index => {
                Err(line.error(format!("refers to vertex {index}, expected 0 to {}", n_vertices as i64 - 1)))
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_usual_variants() {
        let body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 1 2\n";
        // ModelNet40 puts the counts directly after the word.
        for header in ["OFF\n# c\n4 2 0\n", "OFF 4 2 0\n", "OFF4 2 0\n", "COFF\n4 2\n", "4 2 0\n"] {
            let mesh = parse(format!("{header}{body}").as_bytes()).unwrap();
            assert_eq!(mesh.vertices.len(), 4);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        }
    }

    #[test]
    fn says_where_it_is_broken() {
        let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error("PLY\n").starts_with("line 1: starts with \"PLY\", expected OFF"));
        assert!(error("OFF BINARY\n").contains("convert"));
        assert!(
            error("OFF\n1152921504606846976 1 0\n").starts_with("line 2: the number of vertices is 1152")
        );
        assert!(error("OFF\n1 1 0\n0 0 0\n").starts_with("end of the file: "));
        assert_eq!(error("OFF\n1 1 0\n0 0 0\n3 0 0 1"), "line 4: refers to vertex 1, expected 0 to 0");
        assert_eq!(error("OFF\n1 1 0\n0 0 0\n3 0 0"), "line 4: states 3 corners but lists 2");
    }
}
