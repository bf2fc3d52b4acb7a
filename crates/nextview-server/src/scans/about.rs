use nextview_scan::files::{self, Overwrite};
use nextview_scan::{Fault, Faults, ScanConfig};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

/// Metadata of a scan, stored next to its journal in the scan's folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct About {
    /// Time of creation: UTC, RFC 3339.
    pub created: String,
    /// Whether a proposed view must be accepted before it is returned.
    pub confirm_views: bool,
    /// Whether views are withheld for now.
    pub is_paused: bool,
    /// Number of frames after which the next view was accepted; `None` if it is not.
    pub accepted_after: Option<usize>,
    /// Number of frames after which a view was requested: the next frame belongs to it, even after a kill.
    #[serde(default)]
    pub asked_after: Option<usize>,
    /// The configuration as given, as TOML; `after` as it is [kept](ScanConfig::kept_in) there.
    pub config: String,
}

impl About {
    /// Name of the file.
    pub const FILE: &str = "server.json";

    /// Maximum size of the file: a configuration may have a megabyte.
    const MAX_BYTES: u64 = 1 << 22;

    /// Loads the metadata in the folder of a scan, with its configuration.
    pub fn load(dir: &Path) -> Result<(Self, ScanConfig), Faults> {
        let path = dir.join(Self::FILE);
        let text = files::read_text(&path, Self::MAX_BYTES)?;
        let about: Self = serde_json::from_str(&text).map_err(|error| Fault::data(error).in_file(&path))?;
        let config = about.config(dir).map_err(|faults| faults.in_file(&path))?;
        Ok((about, config))
    }

    /// Saves the metadata; it is on the disk on return.
    pub fn save(&self, dir: &Path) -> Result<(), Fault> {
        files::write(&dir.join(Self::FILE), &Overwrite::results(), |w| {
            serde_json::to_writer(&mut *w, self).map_err(Fault::data)?;
            Ok(w.write_all(b"\n")?)
        })
    }

    /// The configuration of the scan in this folder.
    pub fn config(&self, dir: &Path) -> Result<ScanConfig, Faults> {
        Ok(ScanConfig::parse(&self.config, None, None)?.found_from(dir))
    }
}
