//! The folder of results, as the program writes it.

use nextview_report::page_of_scan;
use nextview_scan::files::{Overwrite, ResultFolder};
use nextview_scan::{
    Fault, Faults, Results, ScanConfig, ScanRecord, ScanState, begin_results, write_results,
};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Begins the folder. Fails if it cannot take the results. `force` replaces existing results, but no input
/// file.
pub fn begin(dir: &Path, force: bool, inputs: Vec<PathBuf>) -> Result<ResultFolder, Faults> {
    let rule = Overwrite::forced(force);
    begin_results(dir, rule.but(inputs))
}

/// Writes all results of a scan, with the page that shows it. Everything that could be made is written; the
/// faults of the rest are returned with the record.
pub fn publish(
    mut folder: ResultFolder,
    config: &ScanConfig,
    scan: &ScanState<'_>,
    command: &str,
) -> Result<(ScanRecord, Option<Faults>), Faults> {
    let Results { record, faults } = write_results(&mut folder, config, scan)?;
    let text = toml::to_string(config).map_err(Fault::data)?;
    let page = page_of_scan(scan, &record, config, command, &text);
    folder.add("report.html", |w| Ok(w.write_all(page.as_bytes())?))?;
    folder.publish()?;
    Ok((record, faults))
}
