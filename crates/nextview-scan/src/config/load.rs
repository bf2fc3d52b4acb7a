//! Reads a configuration from a text or a table and reports all its faults at once.

use super::value::{self, Mismatch, What, read_value};
use super::{Positions, Profile, ScanConfig, SourceConfig};
use crate::{Fault, FaultKind, Faults, FilePosition, files};
use glam::DVec2;
use nextview::sensor::Intrinsics;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;
use toml::{Table, Value};

/// Maximum size of a configuration file in bytes: two hundred times that of a scan with all keys. Reading one
/// takes a hundred times its size in memory.
const MAX_BYTES: u64 = 1 << 20;

impl ScanConfig {
    /// Reads a TOML file; see [`parse`](Self::parse).
    pub fn load(file: &Path, profile: Option<Profile>) -> Result<Self, Faults> {
        Self::parse(&files::read_text(file, MAX_BYTES)?, Some(file), profile)
    }

    /// Applies the values of a TOML text over those of its profile. If the text is a file's, every fault
    /// states its place in it.
    ///
    /// `profile` overrides the profile in the text.
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

    /// Applies the values of a table over those of its sensor, if any, and over those of its profile or the
    /// default one. Fails as [`check_with_files`](Self::check_with_files) does.
    pub fn from_table(mut table: Table) -> Result<Self, Faults> {
        let mut faults = Vec::new();
        let profile = take_wrong(&mut table, "profile", &mut faults).unwrap_or_default();
        let base = Self::of_profile(profile);
        #[cfg(feature = "simulated")]
        let base = with_sensor(base, &mut table, &mut faults);
        // The defaults of a misspelt profile or sensor are unknown.
        let knows_defaults = faults.is_empty();
        if table.contains_key("recording") && table.contains_key("live") {
            table.remove("recording");
            faults.push(SourceConfig::two());
        }
        let base = Table::try_from(base).map_err(Fault::data)?;
        let config: Option<Self> = read_over(&base, &mut table, Self::out_of_range, &mut faults);
        if let Some(config) = config.as_ref().filter(|_| knows_defaults) {
            faults.extend(config.contradictions());
            faults.extend(config.unloadable());
        }
        match config {
            Some(config) if faults.is_empty() => Ok(config),
            _ => Err(Faults::of(faults).expect("without a configuration, there is a fault")),
        }
    }

    /// Whether a configuration has this top-level key.
    pub fn has_key(key: &str) -> bool {
        let table = Table::from_iter([(key.to_owned(), Value::Table(Table::new()))]);
        let problem = value::read::<Self>(&Value::Table(table)).err();
        !problem.is_some_and(|problem| matches!(problem.what, What::Unknown(_)) && problem.key() == key)
    }
}

/// Returns the value of a key, if present; removes an invalid one from the table.
fn take_wrong<T: DeserializeOwned>(table: &mut Table, key: &str, faults: &mut Vec<Fault>) -> Option<T> {
    let read = read_value(key, table.get(key)?);
    read.map_err(|fault| {
        table.remove(key);
        faults.push(fault);
    })
    .ok()
}

/// Adds the values of the sensor that a table names.
#[cfg(feature = "simulated")]
fn with_sensor(base: ScanConfig, table: &mut Table, faults: &mut Vec<Fault>) -> ScanConfig {
    let Some(name) = take_wrong(table, "sensor", faults) else { return base };
    let mut with = base.clone();
    match with.set_sensor(name) {
        Ok(()) => with,
        Err(wrong) => {
            table.remove("sensor");
            faults.extend(wrong.iter().cloned());
            base
        }
    }
}

/// After this number of faults, the rest of a table is skipped: a table full of faults would take minutes.
const MOST_FAULTS: usize = 100;

/// Reads a table over its defaults, checked by `out_of_range`. A wrong value is removed from the table and
/// the rest is read again until all is valid. `None` if the fault is in no value of the table.
pub(super) fn read_over<T: DeserializeOwned>(
    base: &Table,
    table: &mut Table,
    out_of_range: impl Fn(&T) -> Vec<Fault>,
    faults: &mut Vec<Fault>,
) -> Option<T> {
    loop {
        let whole = Value::Table(merged(base.clone(), table.clone()));
        let found = match value::read(&whole) {
            Ok(read) => {
                let found = out_of_range(&read);
                if found.is_empty() {
                    return Some(read);
                }
                found
            }
            Err(problem) => {
                let found = of_camera(&problem, &whole).unwrap_or_else(|| vec![problem.fault()]);
                // A table that lost its wrong values may lack a key.
                let table_of_key = problem.parent();
                if matches!(problem.what, What::Missing)
                    && is_within(faults, &table_of_key)
                    && remove(table, &table_of_key)
                {
                    continue;
                }
                found
            }
        };
        let mut goes_on = false;
        for fault in found {
            goes_on |= fault.key.as_ref().is_some_and(|key| remove(table, key));
            faults.push(fault);
        }
        if !goes_on || faults.len() >= MOST_FAULTS {
            return None;
        }
    }
}

/// Whether any of the faults lies in a table.
fn is_within(faults: &[Fault], table: &str) -> bool {
    let rest = |key: &String| key.strip_prefix(table).is_some_and(|rest| rest.starts_with('.'));
    faults.iter().filter_map(|fault| fault.key.as_ref()).any(rest)
}

/// All faults in the optics of a camera, which fail as a whole.
fn of_camera(problem: &Mismatch, whole: &Value) -> Option<Vec<Fault>> {
    #[derive(Deserialize)]
    struct Optics {
        width: u32,
        height: u32,
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
    }
    if !matches!(problem.what, What::Other(_)) || problem.key() != "camera" {
        return None;
    }
    let Optics { width, height, fx, fy, cx, cy } = value::read(whole.get("camera")?).ok()?;
    let wrong = Intrinsics::check(width, height, DVec2::new(fx, fy), DVec2::new(cx, cy));
    let faults: Vec<Fault> = wrong.into_iter().map(|error| Fault::of_part("camera", error)).collect();
    (!faults.is_empty()).then_some(faults)
}

impl Fault {
    /// The fault of an unknown key. Its remedy names the nearest known key, or all known keys if they are
    /// few. The prefix is put before each of them.
    pub fn unknown_key<'a>(prefix: &str, word: &str, known: impl Iterator<Item = &'a str> + Clone) -> Self {
        // Words are truncated more often than misspelt, so a common prefix counts for a candidate.
        let alike = |known: &&str| word.chars().zip(known.chars()).take_while(|(a, b)| a == b).count();
        let farness = |known: &&str| distance(word, known) as i64 - alike(known) as i64;
        let nearest = known.clone().min_by_key(farness).filter(|nearest| farness(nearest) <= FARTHEST);
        let key = format!("{prefix}{word}");
        let fault = Self { key: Some(key.clone()), ..Self::data(format!("`{key}` is not a key")) };
        let names: Vec<&str> = known.collect();
        match nearest {
            Some(nearest) => fault.with_remedy(format!("did you mean `{prefix}{nearest}`?")),
            None if (1..=MOST_LISTED).contains(&names.len()) => {
                let table = prefix.strip_suffix('.').unwrap_or(prefix);
                fault.with_remedy(format!("the keys of `{table}` are {}", names.join(", ")))
            }
            None => fault,
        }
    }
}

/// Maximum edit distance of a suggested key.
const FARTHEST: i64 = 3;

/// Maximum number of known keys in a remedy.
const MOST_LISTED: usize = 20;

/// Levenshtein distance between two words.
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

/// Removes the target of a key from a table, from the innermost table on its path. Returns false if there is
/// nothing to remove.
fn remove(table: &mut Table, key: &str) -> bool {
    let (first, rest) = key.split_once('.').unwrap_or((key, ""));
    // A key may itself contain a dot.
    if table.remove(key).is_some() {
        return true;
    }
    if first != SUM_TYPE
        && let Some(Value::Table(inner)) = table.get_mut(first)
        && remove(inner, rest)
    {
        return true;
    }
    table.remove(first).is_some()
}

/// Returns a table in which the dotted key leads to the value.
pub fn nested(key: &str, value: Value) -> Table {
    match key.split_once('.') {
        Some((key, rest)) => Table::from_iter([(key.to_owned(), Value::Table(nested(rest, value)))]),
        None => Table::from_iter([(key.to_owned(), value)]),
    }
}

/// The kind of lens: a value replaces a different kind as a whole.
const SUM_TYPE: &str = "distortion";

/// Returns the first table, overridden by the values of the second.
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
    /// Places the fault at its key below `prefix`; a fault in a file's value becomes the file's.
    pub fn place(&self, fault: Fault, prefix: &str) -> Fault {
        let key = fault.key.as_ref().map(|key| format!("{prefix}{key}"));
        let position = key.and_then(|key| self.find(&key));
        match &self.file {
            Some(file) if fault.place.is_none() => Fault {
                kind: FaultKind::Data,
                place: Some(FilePosition { file: file.clone(), position }),
                ..fault
            },
            _ => fault,
        }
    }
}
