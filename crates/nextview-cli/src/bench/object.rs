//! The objects of a specification.

use super::pattern;
use crate::Failure;
use crate::scan::{ScanConfig, UnitName, short_name};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use std::path::{Path, PathBuf};

/// An object and how large it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectSpec {
    /// A mesh file or `builtin:NAME`.
    pub file: String,
    /// By default that of the file without its extension.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<UnitName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<f64>,
}

/// Reads objects of which each is a text or a table.
pub(super) fn list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<ObjectSpec>, D::Error> {
    let entries = Vec::<toml::Value>::deserialize(deserializer)?;
    let numbered = entries.into_iter().zip(1..);
    let objects = numbered.map(|(entry, number)| {
        let object = match entry {
            toml::Value::String(file) => Ok(ObjectSpec::new(file)),
            table => table.try_into(),
        };
        object.map_err(|e: toml::de::Error| D::Error::custom(format!("object {number}: {}", e.message())))
    });
    objects.collect()
}

impl ObjectSpec {
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: file.into(), name: None, unit: None, size_m: None }
    }

    /// The objects that this one stands for, with whole paths; relative ones are relative to this folder.
    pub fn resolved(&self, folder: &Path) -> Result<Vec<Self>, Failure> {
        if self.file.starts_with("builtin:") {
            return Ok(vec![self.clone()]);
        }
        let files = pattern::expand(&folder.join(&self.file))?;
        if files.len() > 1 && self.name.is_some() {
            let message = format!("{} files match, but only one can have this name", files.len());
            return Err(Failure::data(message).in_file(Path::new(&self.file)));
        }
        files.iter().map(|file| Ok(Self { file: whole_path(file)?, ..self.clone() })).collect()
    }

    /// Its name in the results.
    pub fn name(&self) -> String {
        self.name.clone().unwrap_or_else(|| short_name(&self.file))
    }

    /// The name of the folder its file is in, or `builtin`.
    pub fn data_set(&self) -> String {
        if self.file.starts_with("builtin:") {
            return "builtin".to_owned();
        }
        let folder = Path::new(&self.file).parent().and_then(Path::file_name);
        folder.unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The configuration for this object.
    pub fn configure(&self, config: &ScanConfig) -> ScanConfig {
        ScanConfig {
            object: self.file.clone(),
            unit: self.unit.unwrap_or(config.unit),
            size_m: self.size_m.or(config.size_m),
            ..config.clone()
        }
    }
}

/// The path from the root of the file system on, so that it is the same from everywhere.
pub(super) fn whole_path(path: &Path) -> Result<String, Failure> {
    let whole = std::path::absolute(path).map_err(|e| Failure::from(e).in_file(path))?;
    let text = whole.into_os_string().into_string();
    text.map_err(|path| Failure::data("the name is not Unicode").in_file(&PathBuf::from(path)))
}
