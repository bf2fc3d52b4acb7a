use super::header::{Element, NumberType, PlyFormat, PlyHeader, Property};
use crate::SimError;
use crate::mesh::text::{NumberedLine, lines};

/// The content after the header, read element by element.
pub(super) enum Body<'a> {
    Text { lines: Box<dyn Iterator<Item = NumberedLine<'a>> + 'a>, n_bytes: usize },
    Binary { bytes: &'a [u8], at: usize, is_big: bool },
}

/// The values of one element, in order.
pub(super) enum Values<'b, 'a> {
    Text { line: NumberedLine<'a>, word: usize },
    Binary { bytes: &'a [u8], at: &'b mut usize, is_big: bool },
}

impl<'a> Body<'a> {
    pub fn new(header: &PlyHeader, bytes: &'a [u8]) -> Self {
        let text = &bytes[header.n_bytes..];
        match header.format {
            PlyFormat::Text => {
                Self::Text { lines: Box::new(lines(text, header.n_lines + 1)), n_bytes: text.len() }
            }
            PlyFormat::LittleEndian => Self::Binary { bytes, at: header.n_bytes, is_big: false },
            PlyFormat::BigEndian => Self::Binary { bytes, at: header.n_bytes, is_big: true },
        }
    }

    /// Fails if the file is too short for the header's number of elements, whatever they contain.
    pub fn check_size(&self, element: &Element) -> Result<(), SimError> {
        let Element { name, count, properties } = element;
        let (place, n_left, size) = match self {
            // In text a value takes a digit and a separator.
            Self::Text { n_bytes, .. } => ("header".into(), *n_bytes + 1, 2 * properties.len()),
            Self::Binary { bytes, at, .. } => {
                (format!("byte {at}"), bytes.len() - at, properties.iter().map(Property::min_size).sum())
            }
        };
        if count.saturating_mul(size as u64) > n_left as u64 {
            let problem = format!(
                "the header states {count} {name} elements of at least {size} bytes, but {n_left} bytes are left; \
                 the file is truncated or the header wrong"
            );
            return Err(SimError::format(place, problem));
        }
        Ok(())
    }

    /// Returns the next element.
    pub fn element(&mut self, element: &Element) -> Result<Values<'_, 'a>, SimError> {
        match self {
            Self::Text { lines, .. } => {
                let line = lines.next().ok_or_else(|| {
                    let problem =
                        format!("fewer lines than the {} {} elements stated", element.count, element.name);
                    SimError::format("end of the file", problem)
                })?;
                Ok(Values::Text { line, word: 0 })
            }
            Self::Binary { bytes, at, is_big } => Ok(Values::Binary { bytes, at, is_big: *is_big }),
        }
    }
}

impl Values<'_, '_> {
    /// Returns the next value.
    pub fn number(&mut self, kind: NumberType) -> Result<f64, SimError> {
        match self {
            Self::Text { line, word } => {
                *word += 1;
                line.number(*word - 1, "a number")
            }
            Self::Binary { bytes, at, is_big } => {
                let Some(value) = bytes.get(**at..**at + kind.size()) else {
                    return Err(self.error("the file ends inside an element; it is truncated"));
                };
                **at += kind.size();
                Ok(decode(value, kind, *is_big))
            }
        }
    }

    /// Reads the length of a list of `item`s, which must fit into the rest of the file.
    pub fn length(&mut self, length: NumberType, item: NumberType) -> Result<usize, SimError> {
        let stated = self.number(length)?;
        let max = match self {
            Self::Text { line, word } => line.words().len() - *word,
            Self::Binary { bytes, at, .. } => (bytes.len() - **at) / item.size(),
        };
        if stated.fract() == 0.0 && stated >= 0.0 && stated <= max as f64 {
            return Ok(stated as usize);
        }
        Err(self.error(format!(
            "a list of {stated} values, but only {max} can follow; the file is damaged or truncated"
        )))
    }

    /// Skips a property.
    pub fn skip(&mut self, property: &Property) -> Result<(), SimError> {
        match *property {
            Property::Scalar { kind, .. } => self.number(kind).map(drop),
            Property::List { length, item, .. } => {
                let n = self.length(length, item)?;
                match self {
                    Self::Text { word, .. } => *word += n,
                    Self::Binary { at, .. } => **at += n * item.size(),
                }
                Ok(())
            }
        }
    }

    /// Fails if the line has more values than the element.
    pub fn end(self) -> Result<(), SimError> {
        match &self {
            Self::Text { line, word } if line.words().len() > *word => {
                Err(self
                    .error(format!("has {} words, expected {word} as the header states", line.words().len())))
            }
            _ => Ok(()),
        }
    }

    /// Returns an error at the current place.
    pub fn error(&self, problem: impl Into<String>) -> SimError {
        match self {
            Self::Text { line, .. } => line.error(problem),
            Self::Binary { at, .. } => SimError::format(format!("byte {at}"), problem),
        }
    }
}

/// A number from its [`NumberType::size`] bytes.
fn decode(value: &[u8], kind: NumberType, is_big: bool) -> f64 {
    let mut bytes = [0; 8];
    let bytes = &mut bytes[..value.len()];
    bytes.copy_from_slice(value);
    if is_big {
        bytes.reverse();
    }
    match (kind, &*bytes) {
        (NumberType::I8, &[a]) => a as i8 as f64,
        (NumberType::U8, &[a]) => a as f64,
        (NumberType::I16, &[a, b]) => i16::from_le_bytes([a, b]) as f64,
        (NumberType::U16, &[a, b]) => u16::from_le_bytes([a, b]) as f64,
        (NumberType::I32, &[a, b, c, d]) => i32::from_le_bytes([a, b, c, d]) as f64,
        (NumberType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f64,
        (NumberType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]) as f64,
        (NumberType::F64, &[a, b, c, d, e, f, g, h]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        _ => unreachable!("the caller cuts out the size of the kind"),
    }
}
