use crate::source::TrackedFile;
use crate::tree::{Octree, TreeKind};
use glam::DVec3;
use nextview::Error;
use nextview::geometry::{Lattice, VoxelKey};
use std::io::{self, Read, Write};

/// The encoding of the nodes after the header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encoding {
    /// Log-odds, and colours, of every node.
    Ot,
    /// Free or occupied for every leaf.
    Bt,
}

impl Encoding {
    /// Returns the first line of a file.
    fn magic(self) -> &'static str {
        match self {
            Self::Ot => "# Octomap OcTree file",
            Self::Bt => "# Octomap OcTree binary file",
        }
    }
}

/// The text in front of the nodes.
#[derive(Debug)]
pub(crate) struct MapHeader {
    pub encoding: Encoding,
    pub kind: TreeKind,
    pub voxel_size: f64,
    /// The voxel in the middle of the tree.
    pub origin: VoxelKey,
    /// As stated in the file; it must not be used to reserve memory.
    pub n_nodes: u64,
}

impl MapHeader {
    pub fn read(source: &mut TrackedFile<impl Read>) -> Result<Self, Error> {
        let first = source.line()?;
        let encoding = read_magic(&first).map_err(|problem| source.error_in_line(problem))?;
        let mut fields = HeaderFields::default();
        loop {
            let line = source.line()?;
            if line == "data" {
                return fields.complete(encoding).map_err(|problem| source.error_in_line(problem));
            }
            fields.take_line(&line).map_err(|problem| source.error_in_line(problem))?;
        }
    }
}

/// The first word of a comment that gives the map's offset.
const OFFSET: &str = "offset_m";

/// Writes OctoMap's header, with its invitation to edit the comments, and the offset of a distant map. The
/// file has `n_nodes` nodes.
pub(crate) fn write_header(
    out: &mut impl Write,
    encoding: Encoding,
    tree: &Octree,
    n_nodes: usize,
) -> io::Result<()> {
    writeln!(out, "{}", encoding.magic())?;
    writeln!(out, "# (feel free to add / change comments, but leave the first line as it is!)\n#")?;
    if tree.origin() != VoxelKey::ZERO {
        let [x, y, z] = (tree.origin().as_dvec3() * tree.voxel_size()).to_array();
        writeln!(out, "# {OFFSET} {x} {y} {z}")?;
    }
    writeln!(out, "id {}", id(tree.kind()))?;
    writeln!(out, "size {n_nodes}")?;
    writeln!(out, "res {}", format_like_cpp(tree.voxel_size()))?;
    writeln!(out, "data")
}

fn id(kind: TreeKind) -> &'static str {
    match kind {
        TreeKind::OcTree => "OcTree",
        TreeKind::ColorOcTree => "ColorOcTree",
    }
}

/// Returns the shortest text that reads back as the same number. If six digits are enough, it has the bytes
/// of a C++ stream.
fn format_like_cpp(number: f64) -> String {
    if (1e-4..1e6).contains(&number) {
        return number.to_string();
    }
    let text = format!("{number:e}");
    let (digits, exponent) = text.split_once('e').expect("this format has an exponent");
    format!("{digits}e{:+03}", exponent.parse::<i32>().expect("the exponent of a number is one"))
}

fn read_magic(line: &str) -> Result<Encoding, String> {
    // Like OctoMap, this compares only the start.
    [Encoding::Ot, Encoding::Bt].into_iter().find(|e| line.starts_with(e.magic())).ok_or_else(|| {
        let [ot, bt] = [Encoding::Ot, Encoding::Bt].map(Encoding::magic);
        format!("found {:?}, expected '{ot}' or '{bt}'", start_of(line))
    })
}

#[derive(Default)]
struct HeaderFields {
    id: Option<TreeKind>,
    size: Option<u64>,
    res: Option<f64>,
    offset_m: Option<DVec3>,
}

impl HeaderFields {
    fn take_line(&mut self, line: &str) -> Result<(), String> {
        if let Some(numbers) = line.strip_prefix("# ").and_then(|line| line.strip_prefix(OFFSET)) {
            self.offset_m = Some(parse_offset(numbers)?);
            return Ok(());
        }
        let mut words = line.split_whitespace();
        match (words.next(), words.next(), words.next()) {
            (None, ..) => Ok(()),
            (Some(word), ..) if word.starts_with('#') => Ok(()),
            (Some(name), Some(value), None) => self.set(name, value),
            _ => Err(format!("found {:?}, expected a comment or a field and its value", start_of(line))),
        }
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        let is_first = match name {
            "id" => self.id.replace(parse_id(value)?).is_none(),
            "size" => self.size.replace(parse_size(value)?).is_none(),
            "res" => self.res.replace(parse_res(value)?).is_none(),
            _ => return Err(format!("unknown field {:?}, expected id, size, res or data", start_of(name))),
        };
        is_first.then_some(()).ok_or_else(|| format!("the header gives {name} twice, expected it once"))
    }

    fn complete(self, encoding: Encoding) -> Result<MapHeader, String> {
        let missing = |name| move || format!("the header ends here without the field {name}");
        let voxel_size = self.res.ok_or_else(missing("res"))?;
        Ok(MapHeader {
            encoding,
            kind: self.id.ok_or_else(missing("id"))?,
            n_nodes: self.size.ok_or_else(missing("size"))?,
            voxel_size,
            origin: self.offset_m.map_or(Ok(VoxelKey::ZERO), |offset| origin_at(offset, voxel_size))?,
        })
    }
}

fn parse_id(value: &str) -> Result<TreeKind, String> {
    [TreeKind::OcTree, TreeKind::ColorOcTree]
        .into_iter()
        .find(|&kind| id(kind) == value)
        .ok_or_else(|| format!("id is {:?}, supported are OcTree and ColorOcTree", start_of(value)))
}

fn parse_size(value: &str) -> Result<u64, String> {
    value.parse().map_err(|_| format!("size is {:?}, expected a number of nodes", start_of(value)))
}

fn parse_res(value: &str) -> Result<f64, String> {
    let res = value.parse().ok().filter(|&res: &f64| res > 0.0 && res.is_finite());
    res.ok_or_else(|| format!("res is {:?}, expected a positive number of metres", start_of(value)))
}

fn parse_offset(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(DVec3::from_array);
    let finite = numbers.filter(|offset| offset.is_finite());
    finite.ok_or_else(|| format!("{OFFSET} is {:?}, expected three numbers of metres", start_of(text.trim())))
}

/// Returns the voxel at this offset, metres.
fn origin_at(offset: DVec3, voxel_size: f64) -> Result<VoxelKey, String> {
    let voxels = offset / voxel_size;
    let is_near = voxels.abs().max_element() <= Lattice::REACH as f64;
    if is_near && (voxels - voxels.round()).abs().max_element() < 1e-3 {
        return Ok(voxels.round().as_ivec3());
    }
    Err(format!("{OFFSET} is {offset}, expected multiples of the voxel size, at most 2^28 times as large"))
}

/// Returns enough of a text to recognise it in an error.
fn start_of(text: &str) -> String {
    text.chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(fields: &str) -> Result<MapHeader, String> {
        let text = format!("# Octomap OcTree file\n{fields}");
        MapHeader::read(&mut TrackedFile::new(text.as_bytes())).map_err(|e| e.to_string())
    }

    #[test]
    fn takes_fields_in_any_order_with_comments() {
        let header = read("res 0.05\n# a comment\n\nsize 7\r\n  id ColorOcTree\n#x\ndata\n").unwrap();
        assert_eq!((header.kind, header.voxel_size, header.n_nodes), (TreeKind::ColorOcTree, 0.05, 7));
        assert_eq!(header.encoding, Encoding::Ot);
    }

    #[test]
    fn says_what_is_wrong_and_where() {
        let check = |fields: &str, expected: &str| assert_eq!(read(fields).unwrap_err(), expected);
        check("id Tree\n", "line 2: id is \"Tree\", supported are OcTree and ColorOcTree");
        check("id OcTree\nsize -1\n", "line 3: size is \"-1\", expected a number of nodes");
        for res in ["0", "-0.1", "nan", "inf", "1e999", "x"] {
            let expected = format!("line 2: res is {res:?}, expected a positive number of metres");
            check(&format!("res {res}\n"), &expected);
        }
        check("size 1\nsize 1\n", "line 3: the header gives size twice, expected it once");
        check("id OcTree\nsize 1\ndata\n", "line 4: the header ends here without the field res");
        check("origin 1\n", "line 2: unknown field \"origin\", expected id, size, res or data");
        check("res\n", "line 2: found \"res\", expected a comment or a field and its value");
        check("id OcTree\n", "line 3: the file ends here, expected a header that ends with the line 'data'");
        check(&"#".repeat(5000), "line 2: longer than 4096 bytes, expected a line of the header");
    }

    #[test]
    fn names_both_formats_if_the_first_line_is_neither() {
        let problem = MapHeader::read(&mut TrackedFile::new(&b"ply\n"[..])).unwrap_err().to_string();
        assert_eq!(
            problem,
            "line 1: found \"ply\", expected '# Octomap OcTree file' or '# Octomap OcTree binary file'"
        );
    }

    #[test]
    fn prints_numbers_as_cpp_streams_do() {
        for text in ["0.1", "0.01", "0.005", "0.0001", "0.123456", "2", "123456", "1e-05", "2.5e-07", "1e+06"]
        {
            assert_eq!(format_like_cpp(text.parse().unwrap()), text);
        }
        for number in [1.0 / 3.0, 1e-300, 1.7e300, 1234567.8] {
            assert_eq!(format_like_cpp(number).parse(), Ok(number));
        }
    }
}
