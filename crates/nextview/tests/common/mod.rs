//! Where the test data is.

use std::io::Write;
use std::path::PathBuf;

/// The named folder of the test data; none, with a word on stderr, if it is not there.
pub fn data_folder(test: &str, name: &str) -> Option<PathBuf> {
    let default = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
    let folder = std::env::var_os("NEXTVIEW_DATA").map_or_else(default, PathBuf::from).join(name);
    if !folder.is_dir() {
        skipped(test, format!("no data, NEXTVIEW_DATA should name a folder with {name}/"));
        return None;
    }
    Some(folder)
}

/// Says that a test was skipped. Not with `eprintln`, whose output the test runner shows of failed tests
/// only.
pub fn skipped(test: &str, why: String) {
    writeln!(std::io::stderr(), "SKIPPED {test}: {why}").expect("stderr is open");
}
