//! STL, binary and text. Corners with equal coordinates become one vertex.

use super::raw::RawMesh;
use super::text::{lines, shown};
use crate::SimError;
use glam::DVec3;
use nextview::text::plain;
use rustc_hash::FxHashMap;

const HEADER: usize = 84;
const RECORD: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SimError> {
    let n_stated = match bytes.get(80..HEADER) {
        Some(&[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as usize,
        _ => 0,
    };
    let expected = HEADER + n_stated * RECORD;
    // A binary file may start with "solid" too, so the size decides.
    if bytes.len() == expected {
        Ok(parse_binary(&bytes[HEADER..]))
    } else if is_text(bytes) {
        parse_text(bytes)
    } else if bytes.len() < HEADER {
        let problem = format!(
            "the file ends, too short for an STL: binary ones have at least {HEADER} bytes, texts begin with solid"
        );
        Err(SimError::format(format!("byte {}", bytes.len()), problem))
    } else {
        let problem = format!(
            "states {n_stated} triangles, which take {expected} bytes, but the file has {}; it is truncated \
             or not STL",
            bytes.len()
        );
        Err(SimError::format("byte 80", problem))
    }
}

/// Whether the file starts with the keyword of the text format, in any encoding. Not all encodings can be
/// read, but the error should say so.
fn is_text(bytes: &[u8]) -> bool {
    let letters = bytes.iter().filter(|byte| byte.is_ascii_graphic()).map(u8::to_ascii_lowercase);
    letters.take(5).eq(*b"solid")
}

fn parse_binary(records: &[u8]) -> RawMesh {
    let mut weld = Weld::default();
    for record in records.chunks_exact(RECORD) {
        let number = |i: usize| {
            let at = 12 + 4 * i;
            f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]) as f64
        };
        let corners = [0, 3, 6].map(|i| weld.vertex(DVec3::new(number(i), number(i + 1), number(i + 2))));
        weld.mesh.push_polygon(&corners);
    }
    weld.mesh
}

fn parse_text(bytes: &[u8]) -> Result<RawMesh, SimError> {
    let mut weld = Weld::default();
    let mut corners = Vec::new();
    let mut is_complete = false;
    for line in lines(&plain(bytes)?, 1) {
        match line.keyword().to_ascii_lowercase().as_slice() {
            b"vertex" => corners.push(weld.vertex(line.point(1)?)),
            b"endloop" => {
                weld.mesh.push_polygon(&corners);
                corners.clear();
            }
            b"endsolid" => is_complete = true,
            b"solid" => is_complete = false,
            b"facet" | b"outer" | b"endfacet" => {}
            _ => {
                let problem = format!("{:?} is not a word of STL", shown(line.keyword()));
                return Err(line.error(problem));
            }
        }
    }
    if !is_complete || !corners.is_empty() {
        return Err(SimError::format("end of the file", "expected endsolid; the file is truncated"));
    }
    Ok(weld.mesh)
}

/// Gives vertices with equal coordinates the same number.
#[derive(Default)]
struct Weld {
    mesh: RawMesh,
    numbers: FxHashMap<[u64; 3], u32>,
}

impl Weld {
    fn vertex(&mut self, position: DVec3) -> u32 {
        // Adding zero makes -0 and 0 the same bits.
        let bits = (position + 0.0).to_array().map(f64::to_bits);
        let vertices = &mut self.mesh.vertices;
        *self.numbers.entry(bits).or_insert_with(|| {
            vertices.push(position);
            vertices.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &[u8] = b"solid two triangles\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
        vertex 0 1 0\nendloop\nendfacet\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 1 0 0\nVERTEX 1 1e0 0\n\
        VERTEX -0 1 0\nENDLOOP\nENDFACET\nendsolid two triangles\n";

    fn binary(header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(2_u32.to_le_bytes());
        for corners in [[[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]] {
            bytes.extend([0; 12]);
            for [x, y] in corners {
                bytes.extend([x as f32, y as f32, 0.0].iter().flat_map(|c| c.to_le_bytes()));
            }
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn reads_text_and_binary_and_joins_corners() {
        for bytes in [TEXT.to_vec(), binary(b"made by hand"), binary(b"solid but binary")] {
            let mesh = parse(&bytes).unwrap();
            assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y]);
            assert_eq!(mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
        }
    }

    #[test]
    fn says_where_it_is_broken() {
        let error = |bytes: &[u8]| parse(bytes).unwrap_err().to_string();
        let cut = error(&binary(b"x")[..120]);
        assert!(cut.contains("2 triangles") && cut.contains("184 bytes") && cut.contains("120"), "{cut}");
        assert!(error(&TEXT[..120]).contains("truncated"));
        assert!(error(b"solid a\nfacet normal 0 0 1\nvortex 1 2 3").starts_with("line 3: \"vortex\""));
        assert!(error(b"solid a\nvertex 1 2").starts_with("line 2: has 3 words"));
        assert_eq!(
            error(b"hello\n"),
            "byte 6: the file ends, too short for an STL: binary ones have at least 84 bytes, texts begin with solid"
        );
        assert!(error(b"").contains("byte 0: the file ends, too short"));
        let mut absurd = binary(b"x");
        absurd[80..84].fill(0xFF);
        assert!(error(&absurd).contains("4294967295 triangles"));
    }
}
