use crate::SimError;
use crate::mesh::text::shown;

/// Encoding of the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlyFormat {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl NumberType {
    /// Returns the size in a binary file, bytes.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn parse(name: &str) -> Option<Self> {
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
}

/// A value, or a list of values, that each element has.
#[derive(Debug)]
pub(super) enum Property {
    Scalar { name: String, kind: NumberType },
    List { name: String, length: NumberType, item: NumberType },
}

impl Property {
    pub fn name(&self) -> &str {
        match self {
            Self::Scalar { name, .. } | Self::List { name, .. } => name,
        }
    }

    /// Returns the fewest bytes it takes in a binary file.
    pub fn min_size(&self) -> usize {
        match self {
            Self::Scalar { kind, .. } => kind.size(),
            Self::List { length, .. } => length.size(),
        }
    }
}

/// The header's description of one kind of element.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// The header.
#[derive(Debug)]
pub(super) struct PlyHeader {
    pub format: PlyFormat,
    pub elements: Vec<Element>,
    /// Size of the header in bytes.
    pub n_bytes: usize,
    /// Size of the header in lines.
    pub n_lines: usize,
}

impl PlyHeader {
    /// Parses a header. Every line ends as the first one does; letters may be of any case.
    pub fn parse(bytes: &[u8]) -> Result<Self, SimError> {
        let end = line_end(bytes);
        let mut format = None;
        let mut elements = Vec::new();
        let mut n_bytes = 0;
        for (i, raw) in bytes.split_inclusive(|&byte| byte == end).enumerate() {
            n_bytes += raw.len();
            let error = |problem: String| SimError::format(format!("line {}", i + 1), problem);
            let line = raw.trim_ascii().to_ascii_lowercase();
            let words: Vec<&str> =
                str::from_utf8(&line).unwrap_or_default().split_ascii_whitespace().collect();
            match words.as_slice() {
                ["ply"] if i == 0 => {}
                _ if i == 0 => {
                    return Err(error(format!("starts with {:?}, expected ply", shown(raw.trim_ascii()))));
                }
                ["format", name, ..] => format = Some(parse_format(name).map_err(error)?),
                ["comment" | "obj_info", ..] => {}
                ["element", name, count] => elements.push(parse_element(name, count).map_err(error)?),
                ["property", rest @ ..] => {
                    let element =
                        elements.last_mut().ok_or_else(|| error("property before any element".into()))?;
                    element.properties.push(parse_property(rest).map_err(error)?);
                }
                ["end_header"] => {
                    let format = format.ok_or_else(|| error("the header has no format line".into()))?;
                    return Ok(Self { format, elements, n_bytes, n_lines: i + 1 });
                }
                // A comment may have any encoding.
                _ if line.starts_with(b"comment") || line.starts_with(b"obj_info") => {}
                _ => {
                    return Err(error(format!(
                        "{:?} is not a line of a PLY header",
                        shown(raw.trim_ascii())
                    )));
                }
            }
        }
        Err(SimError::format(
            "end of the file",
            "the header has no end_header line; the file is empty or truncated",
        ))
    }

    /// Returns the element with this name.
    pub fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|e| e.name == name)
    }
}

/// The last byte of the first line: a line feed, or a carriage return that none follows.
fn line_end(bytes: &[u8]) -> u8 {
    match bytes.iter().position(|byte| b"\r\n".contains(byte)) {
        Some(at) if bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}

fn parse_format(name: &str) -> Result<PlyFormat, String> {
    match name {
        "ascii" => Ok(PlyFormat::Text),
        "binary_little_endian" => Ok(PlyFormat::LittleEndian),
        "binary_big_endian" => Ok(PlyFormat::BigEndian),
        _ => {
            Err(format!("unknown format {name:?}, expected ascii, binary_little_endian or binary_big_endian"))
        }
    }
}

fn parse_element(name: &str, count: &str) -> Result<Element, String> {
    let count = count.parse().map_err(|_| format!("{count:?} is not a number of elements"))?;
    Ok(Element { name: name.to_owned(), count, properties: Vec::new() })
}

fn parse_property(words: &[&str]) -> Result<Property, String> {
    let kind = |name: &str| NumberType::parse(name).ok_or_else(|| format!("unknown type {name:?}"));
    match *words {
        ["list", length, item, name] => {
            let (length, item) = (kind(length)?, kind(item)?);
            if matches!(length, NumberType::F32 | NumberType::F64) {
                return Err("the length of a list is a float, expected an integer type".into());
            }
            Ok(Property::List { name: name.to_owned(), length, item })
        }
        [scalar, name] => Ok(Property::Scalar { name: name.to_owned(), kind: kind(scalar)? }),
        _ => Err("expected `property type name` or `property list type type name`".into()),
    }
}
