use super::paths::whole_path;
use super::section::Section;
use super::{FaultList, pattern};
use nextview_scan::{Fault, ScanConfig, UnitName, short_name};
use serde::Serialize;
use std::path::Path;
use toml::Value;

/// An object and its size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectSpec {
    /// A mesh file or `builtin:NAME`. In a file, `*` matches any characters of a name and `**` any folders.
    pub file: String,
    /// Name in the results; by default the file name without its extension.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Unit of the file; by default that of the configuration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<UnitName>,
    /// Length of the longest side, to which the object is scaled; by default that of the configuration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<f64>,
}

impl ObjectSpec {
    /// Creates the object of a file, with the size of the configuration.
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: file.into(), name: None, unit: None, size_m: None }
    }

    /// Reads an entry of the list of objects: the name of a file, or a table.
    pub(super) fn read(entry: Value, index: usize, faults: &mut FaultList) -> Option<Self> {
        let name = format!("object {}", index + 1);
        let table = match entry {
            Value::String(file) => return Some(Self::new(file)),
            Value::Table(table) => table,
            value => {
                let found = value.type_str();
                let fault = Fault::data(format!("{name} is of type {found}, expected a file or a table"));
                faults.add(&format!("objects.{index}"), fault);
                return None;
            }
        };
        let mut section = Section::entry("objects", index, name, table, faults);
        if !section.has("file") {
            section.fault("file", "is missing, expected a mesh file or `builtin:NAME`");
        }
        let file: Option<String> = section.take("file");
        let (name, unit, size_m) = (section.take("name"), section.take("unit"), section.take("size_m"));
        if let Some(size) = size_m.filter(|size: &f64| !(*size > 0.0 && size.is_finite())) {
            section.fault("size_m", &format!("is {size}, expected a positive number of metres"));
        }
        section.end();
        Some(Self { file: file?, name, unit, size_m })
    }

    /// The objects that this one stands for, with absolute paths; relative ones are relative to this folder.
    pub(super) fn resolved(&self, folder: &Path) -> Result<Vec<Self>, Fault> {
        if self.file.starts_with("builtin:") {
            return Ok(vec![self.clone()]);
        }
        let files = pattern::expand(&folder.join(&self.file))?;
        if files.len() > 1 && self.name.is_some() {
            let message = format!("{} files match, but only one can have this name", files.len());
            return Err(Fault::data(message).in_file(Path::new(&self.file)));
        }
        files.iter().map(|file| Ok(Self { file: whole_path(file)?, ..self.clone() })).collect()
    }

    /// Returns the name in the results.
    pub fn name(&self) -> String {
        self.name.clone().unwrap_or_else(|| short_name(&self.file))
    }

    /// Returns the name of the file's folder, or `builtin`.
    pub fn data_set(&self) -> String {
        if self.file.starts_with("builtin:") {
            return "builtin".to_owned();
        }
        let folder = Path::new(&self.file).parent().and_then(Path::file_name);
        folder.unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The configuration for this object.
    pub(crate) fn configure(&self, config: &ScanConfig) -> ScanConfig {
        ScanConfig {
            object: self.file.clone(),
            unit: self.unit.unwrap_or(config.unit),
            size_m: self.size_m.or(config.size_m),
            ..config.clone()
        }
    }
}
