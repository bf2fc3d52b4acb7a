use super::reading::OpenSpec;
use super::{Spec, builtin};
use crate::runs;
use nextview_scan::{Faults, files};
use std::path::Path;

/// Maximum size of a specification, bytes: that of a folder lists every object by its absolute path.
const MAX_BYTES: u64 = 1 << 22;

/// A specification's faults are reported all at once, with line and column if it comes from a file.
impl Spec {
    /// Loads a built-in specification by its name, or else a file. The objects given here replace its own.
    ///
    /// All paths become absolute: relative ones are relative to the file, those of `objects` to the current
    /// folder.
    pub fn load(name: &str, objects: &[String]) -> Result<Self, Faults> {
        if let Some(text) = builtin::by_name(name) {
            return Self::complete(OpenSpec::of(text, None)?, Path::new(""), objects);
        }
        let path = Path::new(name);
        let text = files::read_text(path, MAX_BYTES).map_err(|fault| {
            let known = builtin::list().map(|(name, _)| name).collect::<Vec<_>>().join(", ");
            fault.with_remedy(format!("name a TOML file or one of {known}"))
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::complete(OpenSpec::of(&text, Some(path))?, folder, objects)
    }

    /// Parses a specification from a text; relative paths in it are relative to this folder.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, Faults> {
        Self::complete(OpenSpec::of(text, None)?, folder, &[])
    }

    /// Reads the specification that a campaign wrote into its folder.
    pub fn of_folder(dir: &Path) -> Result<Self, Faults> {
        let path = dir.join(Self::FILE);
        let text = files::read_text(&path, MAX_BYTES)?;
        finish(OpenSpec::of(&text, Some(&path))?)
    }

    pub(super) fn complete(mut reading: OpenSpec, folder: &Path, objects: &[String]) -> Result<Self, Faults> {
        match objects {
            [] => reading.complete_objects(folder),
            objects => reading.replace_objects(objects),
        }
        reading.complete_variants(folder);
        finish(reading)
    }
}

/// The specification if its runs can be identified and configured.
fn finish(mut reading: OpenSpec) -> Result<Spec, Faults> {
    runs::check(&reading.spec, &mut reading.faults);
    reading.faults.placed(&reading.positions).or(reading.spec)
}
