use super::paths::{value_at, whole_path};
use super::section::Section;
use super::values::check_distinct;
use super::{FaultList, FirstViews, ObjectSpec, Spec, VariantSpec};
use nextview_scan::{Fault, Faults, Positions, SensorName, ViewSpaceName};
use std::path::Path;
use toml::{Table, Value};

/// A specification that is being read from a text, with the faults found so far.
pub(super) struct OpenSpec {
    pub spec: Spec,
    pub positions: Positions,
    pub faults: FaultList,
}

impl OpenSpec {
    /// Reads the text; only a text that is not TOML fails at once.
    pub fn of(text: &str, file: Option<&Path>) -> Result<Self, Faults> {
        let (positions, table) = Positions::read(text, file)?;
        let mut faults = FaultList::default();
        let spec = spec(table, &mut faults);
        Ok(Self { spec, positions, faults })
    }

    /// Finds the files of the objects, relative to this folder; the default is the built-in objects.
    pub fn complete_objects(&mut self, folder: &Path) {
        if self.spec.objects.is_empty() {
            self.spec.objects = nextview_sim::builtin::names()
                .map(|name| ObjectSpec::new(format!("builtin:{name}")))
                .collect();
            return;
        }
        let objects = std::mem::take(&mut self.spec.objects);
        for (object, i) in objects.into_iter().zip(0..) {
            match object.resolved(folder) {
                Ok(objects) => self.spec.objects.extend(objects),
                Err(fault) => self.faults.add(&format!("objects.{i}"), fault),
            }
        }
    }

    /// Replaces the objects of the specification.
    pub fn replace_objects(&mut self, objects: &[String]) {
        self.spec.objects.clear();
        for object in objects {
            match ObjectSpec::new(object).resolved(Path::new("")) {
                Ok(objects) => self.spec.objects.extend(objects),
                Err(fault) => self.faults.add_without_key(fault),
            }
        }
    }

    /// Makes the paths in configurations absolute. If there are no variants, adds one with default values.
    pub fn complete_variants(&mut self, folder: &Path) {
        if self.spec.variant.is_empty() {
            self.spec.variant.push(VariantSpec::default());
        }
        complete_table(&mut self.spec.scan, "scan", folder, &mut self.faults);
        for (variant, i) in self.spec.variant.iter_mut().zip(0..) {
            complete_table(&mut variant.scan, &format!("variant.{i}.scan"), folder, &mut self.faults);
            complete_table(&mut variant.sweep, &format!("variant.{i}.sweep"), folder, &mut self.faults);
        }
    }
}

fn spec(table: Table, faults: &mut FaultList) -> Spec {
    let mut section = Section::top(table, faults);
    if !section.has("name") {
        section.fault("name", "is missing, expected a name for the campaign");
    }
    let name: Option<String> = section.take("name");
    let seed = section.take("seed").unwrap_or(0);
    let seeds = section.take("seeds").unwrap_or_else(|| vec![0]);
    let view_seeds: Option<Vec<u64>> = section.take("view_seeds");
    let first_views: FirstViews = section.take("first_views").unwrap_or_default();
    let scan = section.take("scan").unwrap_or_default();
    let objects: Option<Vec<Value>> = section.take("objects");
    let variants = section.take_list("variant");
    section.end();
    faults.check("name", name.as_deref().map_or(Ok(()), check_name));
    faults.check("seeds", check_distinct("seeds", &seeds));
    let view_seeds_check = view_seeds.as_ref().map_or(Ok(()), |seeds| check_distinct("view_seeds", seeds));
    faults.check("view_seeds", view_seeds_check);
    faults.check("first_views", first_views.check());
    // An existing but empty list does not mean the default objects.
    if objects.as_ref().is_some_and(Vec::is_empty) {
        let fault = Fault::data("objects is empty, expected at least one mesh file or `builtin:NAME`");
        let remedy = "leave out `objects` to use the built-in ones";
        faults.check("objects", Err(fault.with_remedy(remedy)));
    }
    let objects = objects
        .unwrap_or_default()
        .into_iter()
        .zip(0..)
        .filter_map(|(entry, i)| ObjectSpec::read(entry, i, faults));
    let objects = objects.collect();
    let variant = variants.into_iter().zip(0..).filter_map(|(entry, i)| VariantSpec::read(entry, i, faults));
    let variant = variant.collect();
    let name = name.unwrap_or_default();
    Spec { name, seed, seeds, view_seeds, first_views, objects, scan, variant }
}

/// Maximum length of a campaign's name: `bench-` and the number of a shard need some of the 255 bytes of a
/// folder's name.
const MAX_NAME_BYTES: usize = 200;

fn check_name(name: &str) -> Result<(), Fault> {
    let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    if !name.is_empty()
        && name.len() <= MAX_NAME_BYTES
        && !name.starts_with('.')
        && name.chars().all(is_plain)
    {
        return Ok(());
    }
    let expected = "letters, digits, '-', '_' and '.', up to 200 bytes, since it names a folder";
    Err(Fault::data(format!("name is {name:?}, expected {expected}")))
}

/// Makes the paths of the files in a configuration absolute.
fn complete_table(table: &mut Table, key: &str, folder: &Path, faults: &mut FaultList) {
    let is_file = |name: &str| ViewSpaceName(name.to_owned()).rule().is_none();
    let views = value_at(table, "view_space").map_or(Ok(()), |value| complete(value, folder, is_file));
    faults.check(&format!("{key}.view_space"), views);
    let is_sensor_file = |name: &str| SensorName(name.to_owned()).file().is_some();
    let sensor = value_at(table, "sensor").map_or(Ok(()), |value| complete(value, folder, is_sensor_file));
    faults.check(&format!("{key}.sensor"), sensor);
    let weights =
        value_at(table, "nbv_net.weights").map_or(Ok(()), |value| complete(value, folder, |_| true));
    faults.check(&format!("{key}.nbv_net.weights"), weights);
}

/// Makes the paths in a value absolute; a sweep has several.
fn complete(value: &mut Value, folder: &Path, is_file: impl Fn(&str) -> bool + Copy) -> Result<(), Fault> {
    match value {
        Value::Array(values) => values.iter_mut().try_for_each(|value| complete(value, folder, is_file)),
        Value::String(name) if is_file(name) => {
            *name = whole_path(&folder.join(&*name))?;
            Ok(())
        }
        _ => Ok(()),
    }
}
