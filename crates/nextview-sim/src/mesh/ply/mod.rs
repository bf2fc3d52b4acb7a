//! PLY in text form and both binary byte orders: positions and colours of vertices, faces, and, for clouds,
//! normals and expected errors. Everything else is skipped.

mod body;
mod header;

use super::raw::RawMesh;
use crate::SimError;
use body::{Body, Values};
use glam::DVec3;
use header::{Element, PlyFormat, PlyHeader, Property};
use nextview::surface::CloudPoint;
use nextview::text::{plain, unmarked};
use std::borrow::Cow;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, SimError> {
    let (header, bytes) = header_of(bytes)?;
    if header.element("face").is_none() {
        let names: Vec<&str> = header.elements.iter().map(|e| e.name.as_str()).collect();
        let problem =
            format!("has the elements {names:?}, expected vertex and face (a point cloud is not a mesh)");
        return Err(SimError::format("header", problem));
    }
    let columns = [&POSITION[..], all_of(&header, &COLOR)].concat();
    let (mut vertices, mut colors) = (Vec::new(), Vec::new());
    let mesh = read(&header, &bytes, &columns, |values| {
        vertices.push(vector(&values[..3]));
        colors.extend(values.get(3..6).map(color));
    })?;
    Ok(RawMesh { vertices, colors, ..mesh })
}

/// The header and the bytes it describes. A text gets usual line ends, which have the same length.
fn header_of(bytes: &[u8]) -> Result<(PlyHeader, Cow<'_, [u8]>), SimError> {
    let bytes = unmarked(bytes)?;
    let header = PlyHeader::parse(bytes)?;
    let bytes = match header.format {
        PlyFormat::Text => plain(bytes)?,
        PlyFormat::LittleEndian | PlyFormat::BigEndian => Cow::Borrowed(bytes),
    };
    Ok((header, bytes))
}

/// Columns of vertices.
const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const COLOR: [&str; 3] = ["red", "green", "blue"];
const ERROR: [&str; 1] = ["error_m"];

/// The points of a mesh or of a cloud, with normals, colours and expected errors if all their columns exist,
/// and any triangles.
pub(super) fn parse_points(bytes: &[u8]) -> Result<(Vec<CloudPoint>, RawMesh), SimError> {
    let (header, bytes) = header_of(bytes)?;
    let [normals, colors, errors] = [&NORMAL[..], &COLOR, &ERROR].map(|columns| all_of(&header, columns));
    let columns = [&POSITION[..], normals, colors, errors].concat();
    let mut points = Vec::new();
    let mut mesh = read(&header, &bytes, &columns, |values| {
        let (normal, rest) = values[3..].split_at(normals.len());
        let (of_color, error) = rest.split_at(colors.len());
        points.push(CloudPoint {
            // PLY has no missing values: a point without a normal has 0 0 0, one without an error 0.
            normal: (!normals.is_empty()).then(|| vector(normal)).and_then(DVec3::try_normalize),
            color: (!colors.is_empty()).then(|| color(of_color)),
            error: error.first().map(|error| *error as f32).filter(|e| *e > 0.0 && e.is_finite()),
            ..vector(&values[..3]).into()
        });
    })?;
    mesh.color_fault.take().map_or(Ok((points, mesh)), Err)
}

/// These columns if vertices have all of them, otherwise none.
fn all_of<'a>(header: &PlyHeader, columns: &'a [&'a str]) -> &'a [&'a str] {
    let properties = header.element("vertex").map_or(&[][..], |vertex| &vertex.properties);
    let is_there = |column: &&str| properties.iter().any(|property| property.name() == *column);
    if columns.iter().all(is_there) { columns } else { &[] }
}

fn color(values: &[f64]) -> [u8; 3] {
    [0, 1, 2].map(|i| values[i].round() as u8)
}

fn vector(values: &[f64]) -> DVec3 {
    DVec3::new(values[0], values[1], values[2])
}

/// Reads all elements: passes these columns of every vertex to `vertex`, colours as 0 to 255, and reads the
/// faces. The first three columns are required.
fn read(
    header: &PlyHeader,
    bytes: &[u8],
    columns: &[&str],
    mut vertex: impl FnMut(&[f64]),
) -> Result<RawMesh, SimError> {
    let n_vertices = header.element("vertex").map_or(0, |e| e.count);
    let mut body = Body::new(header, bytes);
    let mut mesh = RawMesh::default();
    for element in &header.elements {
        body.check_size(element)?;
        match element.name.as_str() {
            "vertex" => {
                let fault = read_vertices(&mut body, element, columns, &mut vertex)?;
                mesh.color_fault = mesh.color_fault.or(fault);
            }
            "face" => read_faces(&mut body, element, n_vertices, &mut mesh)?,
            _ => skip(&mut body, element)?,
        }
    }
    Ok(mesh)
}

/// Returns the first fault of a colour.
fn read_vertices(
    body: &mut Body,
    element: &Element,
    columns: &[&str],
    vertex: &mut impl FnMut(&[f64]),
) -> Result<Option<SimError>, SimError> {
    let column_of: Vec<Option<usize>> = element.properties.iter().map(|of| column(of, columns)).collect();
    if (0..3).any(|axis| !column_of.contains(&Some(axis))) {
        return Err(SimError::format("header", "element vertex lacks one of the properties x, y and z"));
    }
    let mut fault = None;
    let mut numbers = vec![0.0; columns.len()];
    for _ in 0..element.count {
        let mut values = body.element(element)?;
        for (property, column) in element.properties.iter().zip(&column_of) {
            let (Property::Scalar { kind, .. }, Some(column)) = (property, column) else {
                values.skip(property)?;
                continue;
            };
            let number = values.number(*kind)?;
            numbers[*column] = match COLOR.contains(&columns[*column]) {
                false => number,
                true => color_value(number, *kind).unwrap_or_else(|problem| {
                    fault.get_or_insert_with(|| values.error(problem));
                    0.0
                }),
            };
        }
        values.end()?;
        vertex(&numbers);
    }
    Ok(fault)
}

/// A colour, 0 to 255: integers are used as they are, floats are 0 to 1.
fn color_value(value: f64, kind: header::NumberType) -> Result<f64, String> {
    let most = if matches!(kind, header::NumberType::F32 | header::NumberType::F64) { 1.0 } else { 255.0 };
    match (0.0..=most).contains(&value) {
        true => Ok(value * (255.0 / most)),
        false => Err(format!("a colour is {value}, expected 0 to {most}")),
    }
}

/// Index of a vertex property among the columns.
fn column(property: &Property, columns: &[&str]) -> Option<usize> {
    match property {
        Property::Scalar { name, .. } => columns.iter().position(|column| column == name),
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

fn corner(values: &mut Values, kind: header::NumberType, n_vertices: u64) -> Result<u32, SimError> {
    let index = values.number(kind)?;
    if index.fract() == 0.0 && index >= 0.0 && index < (n_vertices as f64).min(u32::MAX as f64) {
        return Ok(index as u32);
    }
    Err(values.error(format!("a face refers to vertex {index}, but there are {n_vertices} vertices")))
}

fn skip(body: &mut Body, element: &Element) -> Result<(), SimError> {
    // An element without properties takes no space, whatever its count.
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
        // A text header before binary numbers may have any line ends, too; a first byte of 10 is one of them.
        let with_ends = |bytes: Vec<u8>, end: &str| {
            let at = bytes.windows(10).position(|word| word == b"end_header").unwrap() + 11;
            let header = String::from_utf8(bytes[..at].to_vec()).unwrap().replace('\n', end);
            [header.as_bytes(), &bytes[at..]].concat()
        };
        let binaries =
            ["\n", "\r", "\r\n"].map(|end| [false, true].map(|is_big| with_ends(binary(is_big), end)));
        for bytes in binaries.into_iter().flatten().chain([TEXT.as_bytes().to_vec()]) {
            let mesh = parse(&bytes).unwrap();
            assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        }
    }

    #[test]
    fn points_have_normals_and_colours_where_all_their_columns_are_there() {
        let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
            property float nx\nproperty float ny\nproperty float nz\nproperty float error_m\nproperty uchar red\n\
            property uchar green\nproperty uchar blue\nend_header\n1 2 3 0 0 2 0.1 9 8 7\n4 5 6 0 0 0 0 1 2 3\n";
        let (points, mesh) = parse_points(text.as_bytes()).unwrap();
        let first = CloudPoint {
            position: DVec3::new(1.0, 2.0, 3.0),
            normal: Some(DVec3::Z),
            color: Some([9, 8, 7]),
            error: Some(0.1),
        };
        let second = CloudPoint { normal: None, color: Some([1, 2, 3]), ..DVec3::new(4.0, 5.0, 6.0).into() };
        assert_eq!((points, mesh.triangles), (vec![first, second], Vec::new()));
        // Red alone is not a colour.
        for bytes in [TEXT.as_bytes().to_vec(), binary(false), binary(true)] {
            let (points, mesh) = parse_points(&bytes).unwrap();
            assert!(points.len() == 4 && points.iter().all(|p| p.color.is_none() && p.normal.is_none()));
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
        let error =
            |kind, color| colored(kind, ["0 0 0", color, "0 0 0"]).unwrap().color_fault.unwrap().to_string();
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
        check("element face", "element edge", "a point cloud is not a mesh");
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
