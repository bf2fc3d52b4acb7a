use crate::{Fault, ScanRecord, files};
use nextview::geometry::Plane;
use std::path::Path;

/// Maximum size of a record in bytes.
const MAX_RECORD: u64 = 1 << 28;

impl ScanRecord {
    /// Reads the record of the results in a folder.
    pub fn read(dir: &Path) -> Result<Self, Fault> {
        let path = dir.join("record.json");
        if !path.exists() {
            let fault = Fault::data("holds no results of a scan: there is no record.json").in_file(dir);
            return Err(fault.with_remedy("name the folder with the results of a scan (`out`)"));
        }
        let text = files::read_text(&path, MAX_RECORD)?;
        serde_json::from_str(&text).map_err(|error| Fault::data(error).in_file(&path))
    }

    /// The table in the model, as last known; `None` if there is none, or if the model combines two
    /// placements and shows only the object.
    pub fn table(&self) -> Option<Plane> {
        if self.turn.is_some_and(|turn| turn.is_known()) {
            return None;
        }
        self.steps.last().and_then(|step| step.table())
    }
}
