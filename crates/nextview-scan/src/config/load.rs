//! From a text or a table to a configuration, with everything that is wrong in it at once.

use super::{Positions, Profile, ScanConfig};
use crate::{Fault, FaultKind, Faults, Place, files};
use std::collections::BTreeSet;
use std::path::Path;
use toml::{Table, Value};

/// Largest configuration file, bytes: two hundred times that of a scan with all its keys. Reading one takes a
/// hundred times its size.
const MAX_BYTES: u64 = 1 << 20;

impl ScanConfig {
    /// Reads a TOML file; see [`parse`](Self::parse).
    pub fn load(file: &Path, profile: Option<Profile>) -> Result<Self, Faults> {
        Self::parse(&files::read_text(file, MAX_BYTES)?, Some(file), profile)
    }

    /// The values of a TOML text over those of its profile. Every fault says where it is, where the text is a
    /// file's.
    ///
    /// `profile` takes the place of the text's own.
    pub fn parse(text: &str, file: Option<&Path>, profile: Option<Profile>) -> Result<Self, Faults> {
        let (positions, mut table) = Positions::read(text, file)?;
        if let Some(profile) = profile {
            table.insert("profile".to_owned(), Value::String(profile.to_string()));
        }
        let config = Self::from_table(table);
        let config = config.map_err(|faults| faults.map(|fault| positions.place(fault, "")))?;
        Ok(match file.and_then(Path::parent) {
            Some(folder) => config.found_from(folder),
            None => config,
        })
    }

    /// The values of a table over those of its sensor, if it names one, over those of its profile, or else of
    /// the default one.
    pub fn from_table(table: Table) -> Result<Self, Faults> {
        let profile = match table.get("profile") {
            Some(value) => {
                value.clone().try_into::<Profile>().map_err(|e| Fault::of_toml("profile", value, &e))?
            }
            None => Profile::default(),
        };
        let base = Self::of_profile(profile);
        #[cfg(feature = "simulated")]
        let base = with_sensor(base, &table)?;
        let base = Table::try_from(base).map_err(Fault::data)?;
        let whole: Result<Self, _> = merged(base.clone(), table.clone()).try_into();
        match whole {
            Ok(config) => config.check().map(|()| config),
            Err(error) => Err(isolated(&base, &table, &error)),
        }
    }
}

/// The values with those of the sensor that a table names.
#[cfg(feature = "simulated")]
fn with_sensor(mut base: ScanConfig, table: &Table) -> Result<ScanConfig, Faults> {
    if let Some(value) = table.get("sensor") {
        let name = value.clone().try_into().map_err(|e| Fault::of_toml("sensor", value, &e))?;
        base.set_sensor(name)?;
    }
    Ok(base)
}

/// The faults of each value by itself, and those of all others together.
fn isolated(base: &Table, table: &Table, error: &toml::de::Error) -> Faults {
    let mut faults: Vec<Fault> = Vec::new();
    let mut sound = base.clone();
    // Sections without defaults, whose keys are nothing by themselves.
    let mut sections = BTreeSet::new();
    for (key, value) in leaves(table) {
        let with = merged(sound.clone(), nested(&key, value.clone()));
        match with.clone().try_into::<ScanConfig>() {
            Ok(_) => sound = with,
            Err(error) if error.message().starts_with("missing field") => {
                sections.extend(key.split('.').next().map(str::to_owned));
            }
            Err(error) => faults.push(Fault::of_toml(&key, value, &error)),
        }
    }
    for section in sections {
        let is_of = |fault: &Fault| fault.key.as_ref().is_some_and(|key| key.starts_with(&section));
        let value = table.get(&section).filter(|_| !faults.iter().any(is_of));
        let with = merged(sound.clone(), value.iter().map(|v| (section.clone(), (*v).clone())).collect());
        match with.clone().try_into::<ScanConfig>() {
            Ok(_) => sound = with,
            Err(error) => faults.push(of_section(&section, &error)),
        }
    }
    if let Ok(config) = sound.try_into::<ScanConfig>() {
        faults.extend(config.check().err().iter().flat_map(Faults::iter).cloned());
    }
    Faults::of(faults).unwrap_or_else(|| Fault::data(error.message()).into())
}

/// What is wrong in a section.
fn of_section(section: &str, error: &toml::de::Error) -> Fault {
    Fault { key: Some(section.to_owned()), ..Fault::data(format!("`{section}`: {}", error.message())) }
}

/// What a value should have been, where it is named by a type of Rust.
fn in_words(expected: &str) -> String {
    match expected {
        "u8" => format!("a whole number, 0 to {}", u8::MAX),
        "u16" => format!("a whole number, 0 to {}", u16::MAX),
        "u32" => format!("a whole number, 0 to {}", u32::MAX),
        "u64" | "usize" => "a whole number, at least 0".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        name if name.starts_with("struct ") => "a table".to_owned(),
        other => other.to_owned(),
    }
}

/// An unknown key, with its nearest neighbour among those of the list, which are in backticks.
fn unknown(key: &str, word: &str, list: &str) -> Fault {
    let prefix = key.find(word).map_or("", |at| &key[..at]);
    Fault::unknown_key(prefix, word, list.split('`').skip(1).step_by(2))
}

impl Fault {
    /// A value that does not fit its key, or an unknown key.
    pub fn of_toml(key: &str, value: &Value, error: &toml::de::Error) -> Self {
        let message = error.message();
        if let Some(known) = message.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`')) {
            return unknown(key, known.0, known.1);
        }
        let expected = message.rsplit_once(", expected ").map(|(_, expected)| expected);
        match expected {
            Some(expected) => {
                Self { kind: FaultKind::Data, ..Self::of_value(key, value, in_words(expected)) }
            }
            None => Self { key: Some(key.to_owned()), ..Self::data(format!("`{key}`: {message}")) },
        }
    }

    /// An unknown key, with its nearest neighbour among the known ones. The prefix leads to both.
    pub fn unknown_key<'a>(prefix: &str, word: &str, known: impl Iterator<Item = &'a str>) -> Self {
        // A word is likelier to be cut short than misspelt: what both begin with counts for it.
        let alike = |known: &&str| word.chars().zip(known.chars()).take_while(|(a, b)| a == b).count();
        let nearest = known.min_by_key(|known| distance(word, known) as i64 - alike(known) as i64);
        let key = format!("{prefix}{word}");
        let fault = Self { key: Some(key.clone()), ..Self::data(format!("`{key}` is not a key")) };
        match nearest {
            Some(nearest) => fault.with_remedy(format!("did you mean `{prefix}{nearest}`?")),
            None => fault,
        }
    }
}

/// Levenshtein's distance between two words.
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.chars().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row.last().copied().unwrap_or_default()
}

/// The values by their dotted keys. What takes the place of a whole sum type is one value.
fn leaves(table: &Table) -> Vec<(String, &Value)> {
    let mut found = Vec::new();
    collect("", table, &mut found);
    found
}

fn collect<'a>(prefix: &str, table: &'a Table, found: &mut Vec<(String, &'a Value)>) {
    for (key, value) in table {
        match value {
            Value::Table(inner) if key != SUM_TYPE && !inner.is_empty() => {
                collect(&format!("{prefix}{key}."), inner, found);
            }
            value => found.push((format!("{prefix}{key}"), value)),
        }
    }
}

/// The table in which the dotted key leads to the value.
pub fn nested(key: &str, value: Value) -> Table {
    match key.split_once('.') {
        Some((key, rest)) => Table::from_iter([(key.to_owned(), Value::Table(nested(rest, value)))]),
        None => Table::from_iter([(key.to_owned(), value)]),
    }
}

/// The kind of lens: its value replaces another kind as a whole.
const SUM_TYPE: &str = "distortion";

/// The first table with the second's values in place of its own.
pub fn merged(mut base: Table, over: Table) -> Table {
    for (key, value) in over {
        let value = match (base.remove(&key), value) {
            (Some(Value::Table(base)), Value::Table(over)) if key != SUM_TYPE => {
                Value::Table(merged(base, over))
            }
            (_, value) => value,
        };
        base.insert(key, value);
    }
    base
}

impl Positions {
    /// The fault where its key stands, which `prefix` leads to; a value of a file is the file's fault.
    pub fn place(&self, fault: Fault, prefix: &str) -> Fault {
        let key = fault.key.as_ref().map(|key| format!("{prefix}{key}"));
        let position = key.and_then(|key| self.find(&key));
        match &self.file {
            Some(file) if fault.place.is_none() => {
                Fault { kind: FaultKind::Data, place: Some(Place { file: file.clone(), position }), ..fault }
            }
            _ => fault,
        }
    }
}
