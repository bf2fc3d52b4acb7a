//! PLY in text form and both binary byte orders: positions and colours of vertices, and faces; everything
//! else is skipped.

mod body;
mod header;

use super::raw::RawMesh;
use crate::SimError;
use body::{Body, Values};
use glam::DVec3;
use header::{Element, Header, Property};

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SimError> {
    let header = Header::parse(bytes)?;
    let n_vertices = header.element("vertex").map_or(0, |e| e.count);
    if header.element("face").is_none() {
        let names: Vec<&str> = header.elements.iter().map(|e| e.name.as_str()).collect();
        let problem =
            format!("has the elements {names:?}, expected vertex and face (a point cloud is no mesh)");
        return Err(SimError::format("header", problem));
    }
    let mut body = Body::new(&header, bytes);
    let mut mesh = RawMesh::default();
    for element in &header.elements {
        body.check_size(element)?;
        match element.name.as_str() {
            "vertex" => read_vertices(&mut body, element, &mut mesh)?,
            "face" => read_faces(&mut body, element, n_vertices, &mut mesh)?,
            _ => skip(&mut body, element)?,
        }
    }
    Ok(mesh)
}

fn read_vertices(body: &mut Body, element: &Element, mesh: &mut RawMesh) -> Result<(), SimError> {
    let axis_of: Vec<Option<usize>> = element.properties.iter().map(axis).collect();
    for axis in 0..3 {
        if !axis_of.contains(&Some(axis)) {
            return Err(SimError::format("header", "element vertex lacks one of the properties x, y and z"));
        }
    }
    let channel_of: Vec<Option<usize>> = element.properties.iter().map(channel).collect();
    let has_color = (0..3).all(|channel| channel_of.contains(&Some(channel)));
    for _ in 0..element.count {
        let mut values = body.element(element)?;
        let (mut position, mut color) = (DVec3::ZERO, [255; 3]);
        for (property, (axis, channel)) in element.properties.iter().zip(axis_of.iter().zip(&channel_of)) {
            match (property, axis, channel) {
                (Property::Scalar { kind, .. }, Some(axis), _) => position[*axis] = values.number(*kind)?,
                (Property::Scalar { kind, .. }, _, Some(channel)) if has_color => {
                    color[*channel] = color_value(&mut values, *kind)?;
                }
                _ => values.skip(property)?,
            }
        }
        values.end()?;
        if has_color {
            mesh.colors.push(color);
        }
        mesh.vertices.push(position);
    }
    Ok(())
}

/// Whole numbers are 0 to 255, others 0 to 1.
fn color_value(values: &mut Values, kind: header::Kind) -> Result<u8, SimError> {
    let most = if matches!(kind, header::Kind::F32 | header::Kind::F64) { 1.0 } else { 255.0 };
    let value = values.number(kind)?;
    if (0.0..=most).contains(&value) {
        return Ok((value * (255.0 / most)).round() as u8);
    }
    Err(values.error(format!("a colour is {value}, expected 0 to {most}")))
}

/// The colour that a property of a vertex is: 0 is red.
fn channel(property: &Property) -> Option<usize> {
    match property {
        Property::Scalar { name, .. } => ["red", "green", "blue"].iter().position(|color| color == name),
        Property::List { .. } => None,
    }
}

/// The coordinate that a property of a vertex is.
fn axis(property: &Property) -> Option<usize> {
    match property {
        Property::Scalar { name, .. } => ["x", "y", "z"].iter().position(|axis| axis == name),
        Property::List { .. } => None,
    }
}

fn read_faces(
    body: &mut Body,
    element: &Element,
    n_vertices: u64,
    mesh: &mut RawMesh,
) -> Result<(), SimError> {
    let is_corners = |p: &Property| matches!(p.name(), "vertex_indices" | "vertex_index");
    if !element.properties.iter().any(is_corners) {
        return Err(SimError::format("header", "element face lacks the list vertex_indices"));
    }
    let mut corners = Vec::new();
    for _ in 0..element.count {
        let mut values = body.element(element)?;
        for property in &element.properties {
            match property {
                Property::List { length, item, .. } if is_corners(property) => {
                    corners.clear();
                    for _ in 0..values.length(*length, *item)? {
                        corners.push(corner(&mut values, *item, n_vertices)?);
                    }
                    mesh.push_polygon(&corners);
                }
                _ => values.skip(property)?,
            }
        }
        values.end()?;
    }
    Ok(())
}

fn corner(values: &mut Values, kind: header::Kind, n_vertices: u64) -> Result<u32, SimError> {
    let index = values.number(kind)?;
    if index.fract() == 0.0 && index >= 0.0 && index < (n_vertices as f64).min(u32::MAX as f64) {
        return Ok(index as u32);
    }
    Err(values.error(format!("a face refers to vertex {index}, but there are {n_vertices} vertices")))
}

fn skip(body: &mut Body, element: &Element) -> Result<(), SimError> {
    // An element without properties takes no space, however many there are.
    let n = if element.properties.is_empty() { 0 } else { element.count };
    for _ in 0..n {
        let mut values = body.element(element)?;
        for property in &element.properties {
            values.skip(property)?;
        }
        values.end()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "ply\nformat ascii 1.0\ncomment two faces\nobj_info x\nelement vertex 4\nproperty float x\n\
        property uchar red\nproperty double y\nproperty float z\nelement nothing 9\nelement face 2\n\
        property float quality\nproperty list uchar int vertex_indices\nend_header\n\
        0 9 0 0\n1 9 0 0\n1 9 1 0\n0 9 1 0\n0.5 4 0 1 2 3\n0.5 3 0 1 2\n";

    fn binary(is_big: bool) -> Vec<u8> {
        let format = if is_big { "binary_big_endian" } else { "binary_little_endian" };
        let header = TEXT.split_inclusive("end_header\n").next().unwrap().replace("ascii", format);
        let mut bytes = header.into_bytes();
        let mut put = |mut value: Vec<u8>| {
            if !is_big {
                value.reverse();
            }
            bytes.extend(value);
        };
        for [x, y] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
            put((x as f32).to_be_bytes().to_vec());
            put(vec![9]);
            put((y as f64).to_be_bytes().to_vec());
            put(0_f32.to_be_bytes().to_vec());
        }
        for corners in [&[0, 1, 2, 3][..], &[0, 1, 2]] {
            put(0.5_f32.to_be_bytes().to_vec());
            put(vec![corners.len() as u8]);
            corners.iter().for_each(|c: &i32| put(c.to_be_bytes().to_vec()));
        }
        bytes
    }

    #[test]
    fn reads_text_and_both_byte_orders() {
        let windows = TEXT.replace('\n', "\r\n");
        for bytes in [TEXT.as_bytes().to_vec(), windows.into_bytes(), binary(false), binary(true)] {
            let mesh = parse(&bytes).unwrap();
            assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        }
    }

    #[test]
    fn colours_are_bytes_or_shares() {
        let colored = |kind: &str, colors: [&str; 3]| {
            let header = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 property {kind} red\nproperty {kind} green\nproperty {kind} blue\nelement face 1\n\
                 property list uchar int vertex_indices\nend_header\n"
            );
            let [a, b, c] = colors;
            parse(format!("{header}0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n").as_bytes())
        };
        let colors = [[255, 0, 128], [1, 2, 3], [0; 3]];
        let bytes = colored("uchar", ["255 0 128", "1 2 3", "0 0 0"]).unwrap();
        assert_eq!(bytes.colors, colors);
        let shares = colored("float", ["1 0 0.5", "0.004 0.008 0.012", "0 0 0"]).unwrap();
        assert_eq!(shares.colors, colors);
        let error = |kind, color| colored(kind, ["0 0 0", color, "0 0 0"]).unwrap_err().to_string();
        assert_eq!(error("float", "0 255 0"), "line 14: a colour is 255, expected 0 to 1");
        assert!(error("int", "0 0 -1").contains("a colour is -1, expected 0 to 255"));
    }

    fn error(bytes: &[u8]) -> String {
        parse(bytes).unwrap_err().to_string()
    }

    #[test]
    fn says_where_the_header_is_broken() {
        let check = |from: &str, to: &str, expected: &str| {
            let message = error(TEXT.replacen(from, to, 1).as_bytes());
            assert!(message.contains(expected), "{message:?} does not contain {expected:?}");
        };
        check("ply\n", "plx\n", "line 1");
        check("ascii", "ternary", "line 2: unknown format \"ternary\"");
        check("element vertex 4", "element vertex many", "line 5");
        check("property float x", "property fluff x", "line 6: unknown type \"fluff\"");
        check("property float x", "property float u", "lacks one of the properties x, y and z");
        check("vertex_indices", "corners", "lacks the list vertex_indices");
        check("element face", "element edge", "a point cloud is no mesh");
        check("end_header", "oops", "line 14");
        check("vertex 4", "vertex 1152921504606846976", "1152921504606846976 vertex");
        check("face 2", "face 1152921504606846976", "1152921504606846976 face");
        check("uchar int", "float int", "line 13");
    }

    #[test]
    fn says_where_the_body_is_broken() {
        let check = |from: &str, to: &str, expected: &str| {
            let message = error(TEXT.replacen(from, to, 1).as_bytes());
            assert!(message.contains(expected), "{message:?} does not contain {expected:?}");
        };
        check("1 9 1 0\n", "1 9 one 0\n", "line 17: \"one\" is not a number");
        check("1 9 1 0\n", "1 9 1\n", "line 17: has 3 words");
        check("1 9 1 0\n", "1 9 1 0 7\n", "line 17: has 5 words, expected 4");
        check("0 1 2 3\n", "0 1 2 4\n", "line 19: a face refers to vertex 4, but there are 4 vertices");
        check("0 1 2 3\n", "0 1 2 -1\n", "line 19: a face refers to vertex -1");
        check("0.5 3 0 1 2\n", "", "end of the file");
        check("4 0 1 2 3\n", "400000000000 0 1 2 3\n", "line 19: a list of 400000000000");
        let whole = binary(false);
        let cut = error(&whole[..whole.len() - 1]);
        assert!(cut.contains("byte 3") && cut.contains("truncated"), "{cut}");
    }
}
