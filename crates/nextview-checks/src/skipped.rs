//! Tests that need something not available on every machine.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;

/// Variable with the requirements that must be present, separated by commas: a test that lacks one fails. 1
/// stands for everything.
const REQUIRED: &str = "NEXTVIEW_REQUIRE_ALL";

/// Variable with the file that lists the skipped tests; by default a file of the process that runs all tests.
const LIST: &str = "NEXTVIEW_SKIPPED";

/// Reports that a test is skipped, and adds it to the list that [`take_skipped`] returns. `needs` is the
/// missing package or program, or `data`.
///
/// # Panics
/// If `NEXTVIEW_REQUIRE_ALL` requires it.
pub fn skipped(test: &str, needs: &str, why: impl Display) {
    // Not with `eprintln`, whose output the test runner shows only for failed tests.
    writeln!(std::io::stderr(), "SKIPPED {test}: {why}").expect("stderr is open");
    let why = why.to_string().replace(['\t', '\n'], " ");
    // A single write: lines of several processes do not mix.
    let line = format!("{needs}\t{test}\t{why}\n");
    let list = list();
    let file = OpenOptions::new().create(true).append(true).open(&list);
    let added = file.and_then(|mut file| file.write_all(line.as_bytes()));
    added.unwrap_or_else(|error| panic!("{}: {error}", list.display()));
    let required = std::env::var(REQUIRED).unwrap_or_default();
    let is_required = required.split(',').any(|name| name == "1" || name == needs);
    assert!(!is_required, "{test} would be skipped: {why}; {REQUIRED}={required} requires {needs}");
}

/// Returns a file or folder of the reference data; `None` if it is missing, and the test is then [skipped].
///
/// The data is in the folder named by `NEXTVIEW_DATA`, or in `shared/data` next to the workspace.
///
/// # Panics
/// As [`skipped`] does.
pub fn data(test: &str, name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let folder = std::env::var_os("NEXTVIEW_DATA").map_or(default.into(), PathBuf::from);
    let path = std::fs::canonicalize(folder.join(name)).ok();
    if path.is_none() {
        skipped(test, "data", format!("no {name} in the folder of data, which NEXTVIEW_DATA names"));
    }
    path
}

/// Returns the tests skipped since the run began, by their needs, and clears the list unless it belongs to
/// another command. Empty if nothing was skipped.
pub fn take_skipped() -> String {
    let list = list();
    let lines = std::fs::read_to_string(&list).unwrap_or_default();
    if std::env::var_os(LIST).is_none() {
        // There is no file if nothing was skipped.
        let _ = std::fs::remove_file(&list);
    }
    summary(&lines)
}

fn summary(lines: &str) -> String {
    let mut by_need = BTreeMap::<&str, BTreeSet<&str>>::new();
    for line in lines.lines() {
        let mut fields = line.split('\t');
        let (needs, test) = (fields.next().unwrap_or_default(), fields.next().unwrap_or_default());
        by_need.entry(needs).or_default().insert(test);
    }
    let n: usize = by_need.values().map(BTreeSet::len).sum();
    let lines = by_need.iter().map(|(needs, tests)| {
        format!("  without {needs}: {}\n", tests.iter().copied().collect::<Vec<_>>().join(", "))
    });
    if n == 0 { String::new() } else { format!("{n} skipped\n{}", lines.collect::<String>()) }
}

fn list() -> PathBuf {
    std::env::var_os(LIST)
        .map_or_else(|| std::env::temp_dir().join(format!("skipped-tests-{}", parent())), PathBuf::from)
}

/// `cargo test` starts all test programs itself.
#[cfg(unix)]
fn parent() -> u32 {
    std::os::unix::process::parent_id()
}

#[cfg(not(unix))]
fn parent() -> u32 {
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_counts_each_test_once_by_what_it_needs() {
        let lines = "data\tb\tno meshes\nfish\tc\tnot installed\ndata\ta\tno meshes\ndata\tb\tno maps\n";
        assert_eq!(summary(lines), "3 skipped\n  without data: a, b\n  without fish: c\n");
        assert_eq!(summary(""), "");
    }
}
