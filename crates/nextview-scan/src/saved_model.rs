//! Reads the models and the record of a scan's results.

use crate::{Fault, ScanRecord, files};
use glam::DVec3;
use nextview::geometry::Plane;
use nextview::session::ON_TABLE;
use nextview::surface::CloudPoint;
use std::path::Path;

/// A model from a PLY file of a scan's results, also after another tool has saved it in binary form: points,
/// and triangles between them if there are any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedModel {
    /// With normals and colours if the file has them, metres.
    pub points: Vec<CloudPoint>,
    /// By three indices each; faces of more corners are cut into triangles that share the first.
    pub triangles: Vec<[u32; 3]>,
}

/// Largest file that is read, bytes.
const MAX_BYTES: u64 = 1 << 32;

/// The type of a number.
#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

struct Column {
    name: String,
    /// Of the number of entries, if it is a list.
    length: Option<Kind>,
    kind: Kind,
}

struct Element {
    name: String,
    count: usize,
    columns: Vec<Column>,
}

/// Largest record that is read, bytes.
const MAX_RECORD: u64 = 1 << 28;

impl SavedModel {
    /// Reads a file in binary little-endian form.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let bytes = files::read(path, MAX_BYTES)?;
        parse(&bytes).map_err(|problem| Fault::data(problem).in_file(path))
    }

    /// The part that is not the table: of a mesh the triangles above it with their points, of a cloud the
    /// points.
    pub fn above(self, table: Option<Plane>) -> Self {
        let is_above = |point: &CloudPoint| table.is_none_or(|t| t.height(point.position) > ON_TABLE);
        if self.triangles.is_empty() {
            return Self { points: self.points.into_iter().filter(is_above).collect(), ..self };
        }
        let are_above = |triangle: &&[u32; 3]| triangle.iter().all(|&i| is_above(&self.points[i as usize]));
        let triangles: Vec<[u32; 3]> = self.triangles.iter().filter(are_above).copied().collect();
        let mut new_index = vec![None; self.points.len()];
        let mut points = Vec::new();
        let mut renumbered = |i: u32| {
            *new_index[i as usize].get_or_insert_with(|| {
                points.push(self.points[i as usize]);
                points.len() as u32 - 1
            })
        };
        let triangles = triangles.into_iter().map(|triangle| triangle.map(&mut renumbered)).collect();
        Self { points, triangles }
    }
}

impl ScanRecord {
    /// Reads the record of the results in a folder.
    pub fn read(dir: &Path) -> Result<Self, Fault> {
        let path = dir.join("record.json");
        let text = files::read_text(&path, MAX_RECORD)?;
        serde_json::from_str(&text).map_err(|error| Fault::data(error).in_file(&path))
    }

    /// The table that the object stands on, as it was known in the end.
    pub fn table(&self) -> Option<Plane> {
        self.steps.last().and_then(|step| step.table())
    }
}

fn parse(bytes: &[u8]) -> Result<SavedModel, String> {
    let (elements, mut rest) = header(bytes)?;
    let mut model = SavedModel::default();
    for element in &elements {
        let plain = element.columns.iter().filter(|column| column.length.is_none()).map(|c| c.kind.size());
        if plain.sum::<usize>().max(1).saturating_mul(element.count) > rest.len() {
            return Err(format!("ends before its {} entries of {}", element.count, element.name));
        }
        for i in 0..element.count {
            let cut = || format!("ends within {} {i}", element.name);
            match element.name.as_str() {
                "vertex" => model.points.push(point(element, &mut rest).ok_or_else(cut)?),
                _ => {
                    for corners in lists(element, &mut rest).ok_or_else(cut)? {
                        add_face(&mut model, &corners).map_err(|problem| format!("face {i}: {problem}"))?;
                    }
                }
            }
        }
    }
    if let Some(i) = model.points.iter().position(|point| !point.position.is_finite()) {
        return Err(format!("vertex {i} is at {}, expected finite coordinates", model.points[i].position));
    }
    Ok(model)
}

fn header(bytes: &[u8]) -> Result<(Vec<Element>, &[u8]), String> {
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|window| window == end);
    let at = at
        .filter(|_| bytes.starts_with(b"ply\n"))
        .ok_or("is no PLY file, expected a head from `ply` to `end_header`")?;
    let text = std::str::from_utf8(&bytes[..at]).map_err(|_| "has a head that is no text")?;
    let mut elements: Vec<Element> = Vec::new();
    for (i, line) in text.lines().enumerate().skip(1) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let wrong = |expected: &str| format!("line {}: {line:?}, expected {expected}", i + 1);
        match words[..] {
            ["comment" | "obj_info", ..] | [] => {}
            ["format", "binary_little_endian", _] => {}
            ["format", ..] => return Err(wrong("format binary_little_endian 1.0, as a scan writes it")),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong("a count"))?;
                elements.push(Element { name: name.to_owned(), count, columns: Vec::new() });
            }
            ["property", ref words @ ..] => {
                let (length, kind, name) = match words {
                    ["list", length, kind, name] => {
                        (Some(Kind::of(length).ok_or_else(|| wrong("a type"))?), *kind, *name)
                    }
                    [kind, name] => (None, *kind, *name),
                    _ => return Err(wrong("a type and a name")),
                };
                let kind = Kind::of(kind).ok_or_else(|| wrong("a type"))?;
                let element = elements.last_mut().ok_or_else(|| wrong("an element first"))?;
                element.columns.push(Column { name: name.to_owned(), length, kind });
            }
            _ => return Err(wrong("element, property or comment")),
        }
    }
    Ok((elements, &bytes[at + end.len()..]))
}

fn point(element: &Element, rest: &mut &[u8]) -> Option<CloudPoint> {
    let (mut position, mut normal, mut color) = ([None; 3], [None; 3], [None; 3]);
    for column in &element.columns {
        if column.length.is_some() {
            list(column, rest)?;
            continue;
        }
        let value = column.kind.take(rest)?;
        match column.name.as_str() {
            "x" => position[0] = Some(value),
            "y" => position[1] = Some(value),
            "z" => position[2] = Some(value),
            "nx" => normal[0] = Some(value),
            "ny" => normal[1] = Some(value),
            "nz" => normal[2] = Some(value),
            "red" => color[0] = Some(value as u8),
            "green" => color[1] = Some(value as u8),
            "blue" => color[2] = Some(value as u8),
            _ => {}
        }
    }
    let vector = |[x, y, z]: [Option<f64>; 3]| Some(DVec3::new(x?, y?, z?));
    let color = match color {
        [Some(r), Some(g), Some(b)] => Some([r, g, b]),
        _ => None,
    };
    let normal = vector(normal).and_then(DVec3::try_normalize);
    Some(CloudPoint { normal, color, ..vector(position).unwrap_or(DVec3::NAN).into() })
}

/// The lists of an entry; its other columns are skipped.
fn lists(element: &Element, rest: &mut &[u8]) -> Option<Vec<Vec<f64>>> {
    let mut lists = Vec::new();
    for column in &element.columns {
        match column.length {
            Some(_) => {
                let list = list(column, rest)?;
                if matches!(column.name.as_str(), "vertex_indices" | "vertex_index") {
                    lists.push(list);
                }
            }
            None => drop(column.kind.take(rest)?),
        }
    }
    Some(lists)
}

fn list(column: &Column, rest: &mut &[u8]) -> Option<Vec<f64>> {
    let n = column.length?.take(rest)?;
    (n >= 0.0 && n as usize <= rest.len()).then_some(())?;
    (0..n as usize).map(|_| column.kind.take(rest)).collect()
}

fn add_face(model: &mut SavedModel, corners: &[f64]) -> Result<(), String> {
    let n = model.points.len();
    let index = |corner: &f64| match *corner {
        index if index >= 0.0 && index < n as f64 && index.fract() == 0.0 => Ok(index as u32),
        index => Err(format!("refers to vertex {index}, but there are {n} vertices")),
    };
    let corners: Vec<u32> = corners.iter().map(index).collect::<Result<_, _>>()?;
    let pairs = corners.get(1..).unwrap_or_default().windows(2);
    model.triangles.extend(pairs.map(|pair| [corners[0], pair[0], pair[1]]));
    Ok(())
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number that the bytes begin with, which are shortened by it.
    fn take(self, rest: &mut &[u8]) -> Option<f64> {
        Some(match self {
            Self::I8 => i8::from_le_bytes(first(rest)?).into(),
            Self::U8 => u8::from_le_bytes(first(rest)?).into(),
            Self::I16 => i16::from_le_bytes(first(rest)?).into(),
            Self::U16 => u16::from_le_bytes(first(rest)?).into(),
            Self::I32 => i32::from_le_bytes(first(rest)?).into(),
            Self::U32 => u32::from_le_bytes(first(rest)?).into(),
            Self::F32 => f32::from_le_bytes(first(rest)?).into(),
            Self::F64 => f64::from_le_bytes(first(rest)?),
        })
    }
}

fn first<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, after) = rest.split_first_chunk::<N>()?;
    *rest = after;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::surface::write_mesh;

    fn points() -> Vec<CloudPoint> {
        let point = |i: u8| CloudPoint {
            position: DVec3::new(f64::from(i), 0.5, -0.25),
            normal: Some(DVec3::Z),
            color: Some([i, 100, 255]),
            error: None,
        };
        (0..4).map(point).collect()
    }

    fn written(points: &[CloudPoint], triangles: &[[u32; 3]]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, points, None, triangles).unwrap();
        bytes
    }

    #[test]
    fn what_a_scan_writes_reads_back() {
        let triangles = vec![[0, 1, 2], [1, 2, 3]];
        let model = parse(&written(&points(), &triangles)).unwrap();
        assert_eq!(model, SavedModel { points: points(), triangles });
        let plain: Vec<CloudPoint> = points().iter().map(|point| point.position.into()).collect();
        assert_eq!(parse(&written(&plain, &[])).unwrap().points, plain);
    }

    #[test]
    fn what_lies_on_the_table_is_left_out() {
        let table = Some(Plane::new(DVec3::X, DVec3::X).unwrap());
        let model = parse(&written(&points(), &[[0, 2, 3], [3, 2, 2]])).unwrap();
        let above = model.above(table);
        assert_eq!((above.points.len(), above.triangles), (2, vec![[0, 1, 1]]));
        assert_eq!(parse(&written(&points(), &[])).unwrap().above(table).points, points()[2..]);
    }

    #[test]
    fn damage_is_an_error_and_no_panic() {
        let whole = written(&points(), &[[0, 1, 2]]);
        for length in 0..whole.len() {
            assert!(parse(&whole[..length]).is_err(), "{length}");
        }
        for i in 0..whole.len() {
            for byte in [0, 0x7f, 0xff] {
                let mut damaged = whole.clone();
                damaged[i] = byte;
                let _ = parse(&damaged);
            }
        }
        let error = parse(&written(&points(), &[[0, 1, 4]])).unwrap_err();
        assert_eq!(error, "face 0: refers to vertex 4, but there are 4 vertices");
        let ascii = b"ply\nformat ascii 1.0\nend_header\n";
        assert!(
            parse(ascii).unwrap_err().starts_with("line 2: \"format ascii 1.0\", expected format binary")
        );
    }
}
