//! The specification of a campaign: a TOML file.

use super::builtin;
use super::object::{self, ObjectSpec, whole_path};
use super::variant::{VariantSpec, check_distinct};
use crate::Failure;
use crate::scan::ViewSpaceName;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What to scan, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Spec {
    pub name: String,
    #[serde(default = "only_zero")]
    pub seeds: Vec<u64>,
    #[serde(default = "only_zero")]
    pub first_views: Vec<usize>,
    #[serde(default, deserialize_with = "object::list")]
    pub objects: Vec<ObjectSpec>,
    /// Keys of [`ScanConfig`](crate::scan::ScanConfig) for all runs.
    #[serde(default)]
    pub scan: toml::Table,
    #[serde(default)]
    pub variant: Vec<VariantSpec>,
}

fn only_zero<T: From<u8>>() -> Vec<T> {
    vec![T::from(0)]
}

impl Spec {
    /// Reads a specification, built in or from a file. Objects named here take the place of its own. All its paths are whole
    /// then.
    pub fn load(name: &str, meshes: &[String]) -> Result<Self, Failure> {
        let path = Path::new(name);
        let text = match builtin::by_name(name) {
            Some(text) => text.to_owned(),
            None => std::fs::read_to_string(path).map_err(|e| {
                let known = builtin::names().collect::<Vec<_>>().join(", ");
                Failure::data(format!("cannot be read: {e}"))
                    .in_file(path)
                    .with_hint(format!("pass a TOML file or one of {known}"))
            })?,
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut spec = Self::parse(&text, folder, meshes.is_empty()).map_err(|e| e.in_file(path))?;
        if !meshes.is_empty() {
            spec.objects = resolved(meshes.iter().map(ObjectSpec::new), Path::new(""))?;
        }
        Ok(spec)
    }

    /// Reads the specification that a campaign wrote into its folder.
    pub fn reload(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| Failure::data(format!("cannot be read: {e}")).in_file(path))?;
        toml::from_str(&text).map_err(|e| Failure::data(e.to_string().trim_end()).in_file(path))
    }

    fn parse(text: &str, folder: &Path, with_objects: bool) -> Result<Self, Failure> {
        let mut spec: Self = toml::from_str(text).map_err(|e| Failure::data(e.to_string().trim_end()))?;
        spec.check()?;
        if spec.objects.is_empty() {
            spec.objects = nextview_sim::builtin::names()
                .map(|name| ObjectSpec::new(format!("builtin:{name}")))
                .collect();
        } else if with_objects {
            spec.objects = resolved(spec.objects, folder)?;
        }
        if spec.variant.is_empty() {
            spec.variant.push(VariantSpec::default());
        }
        let tables = spec.variant.iter_mut().flat_map(|variant| [&mut variant.scan, &mut variant.sweep]);
        for table in std::iter::once(&mut spec.scan).chain(tables) {
            let is_file = |name: &str| ViewSpaceName(name.to_owned()).rule().is_none();
            table.get_mut("view_space").map_or(Ok(()), |value| resolve(value, folder, is_file))?;
            let weights = table.get_mut("nbv_net").and_then(|value| value.get_mut("weights"));
            weights.map_or(Ok(()), |value| resolve(value, folder, |_| true))?;
        }
        Ok(spec)
    }

    fn check(&self) -> Result<(), Failure> {
        let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
        if self.name.is_empty() || self.name.starts_with('.') || !self.name.chars().all(is_plain) {
            let name = &self.name;
            return Err(Failure::data(format!(
                "name is {name:?}, expected letters, digits, '-', '_' and '.', since it names a folder"
            )));
        }
        check_distinct("seeds", &self.seeds)?;
        check_distinct("first_views", &self.first_views)
    }
}

fn resolved(
    objects: impl IntoIterator<Item = ObjectSpec>,
    folder: &Path,
) -> Result<Vec<ObjectSpec>, Failure> {
    let lists = objects.into_iter().map(|object| object.resolved(folder)).collect::<Result<Vec<_>, _>>()?;
    Ok(lists.concat())
}

/// Makes whole the paths of files, of which a sweep has several.
fn resolve(
    value: &mut toml::Value,
    folder: &Path,
    is_file: impl Fn(&str) -> bool + Copy,
) -> Result<(), Failure> {
    match value {
        toml::Value::Array(values) => values.iter_mut().try_for_each(|value| resolve(value, folder, is_file)),
        toml::Value::String(name) if is_file(name) => {
            *name = whole_path(&folder.join(&*name))?;
            Ok(())
        }
        _ => Ok(()),
    }
}
