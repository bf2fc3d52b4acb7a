use crate::{Fault, Faults, FilePosition};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Table;
use toml::de::{DeTable, DeValue};

/// Positions of keys in a TOML text.
#[derive(Clone, Debug, Default)]
pub struct Positions {
    /// The file of the text, if there is one.
    pub(super) file: Option<PathBuf>,
    /// Line and column by dotted key.
    by_key: BTreeMap<String, (usize, usize)>,
}

impl Positions {
    /// Reads a text. Fails with all its syntax errors.
    pub fn read(text: &str, file: Option<&Path>) -> Result<(Self, Table), Faults> {
        let (document, errors) = DeTable::parse_recoverable(text);
        let faults = errors.iter().map(|error| {
            let position = error.span().map(|span| line_and_column(text, &span));
            let place = file.map(|file| FilePosition { file: file.to_owned(), position });
            Fault { place, ..Fault::data(error.message()) }
        });
        if let Some(faults) = Faults::of(faults.collect()) {
            return Err(faults);
        }
        let mut positions = Self { file: file.map(Path::to_owned), by_key: BTreeMap::new() };
        positions.add("", document.get_ref(), text);
        let table = text.parse().map_err(|error: toml::de::Error| Fault::data(error.message()))?;
        Ok((positions, table))
    }

    /// Returns the line and column, counted from 1, of the key or of its nearest ancestor.
    pub fn find(&self, key: &str) -> Option<(usize, usize)> {
        let mut key = key;
        loop {
            match (self.by_key.get(key), key.rsplit_once('.')) {
                (Some(position), _) => return Some(*position),
                (None, Some((above, _))) => key = above,
                (None, None) => return None,
            }
        }
    }

    fn add(&mut self, prefix: &str, table: &DeTable<'_>, text: &str) {
        for (key, value) in table {
            let path = format!("{prefix}{}", key.get_ref());
            match value.get_ref() {
                DeValue::Table(table) => self.add(&format!("{path}."), table, text),
                DeValue::Array(entries) => {
                    for (i, entry) in entries.iter().enumerate() {
                        if let DeValue::Table(table) = entry.get_ref() {
                            self.add(&format!("{path}.{i}."), table, text);
                        }
                    }
                }
                _ => (),
            }
            self.by_key.insert(path, line_and_column(text, &key.span()));
        }
    }
}

/// Line and column, counted from 1, of the start of this part of the text.
fn line_and_column(text: &str, span: &Range<usize>) -> (usize, usize) {
    let before = text.get(..span.start).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
