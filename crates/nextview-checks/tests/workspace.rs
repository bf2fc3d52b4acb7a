//! The crates are layers, and no crate has import cycles between its files.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview_checks::{check_public_items, import_cycles, upward_dependencies};
use std::fs;
use std::path::Path;

/// From low to high; crates on one line know nothing of each other.
const LAYERS: [&[&str]; 8] = [
    &["nextview", "nextview-checks"],
    &["nextview-sim", "nextview-recording", "nextview-robot"],
    &["nextview-learned"],
    &["nextview-scan"],
    &["nextview-campaign", "nextview-export", "nextview-inspect"],
    &["nextview-report"],
    &["nextview-server", "nextview-ros2"],
    &["nextview-cli"],
];

fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

#[test]
fn dependencies_point_down_only() {
    let faults = upward_dependencies(workspace(), &LAYERS);
    assert!(faults.is_empty(), "upward dependencies:\n{}", faults.join("\n"));
}

#[test]
fn files_import_each_other_without_cycles() {
    let mut faults = Vec::new();
    for entry in fs::read_dir(workspace().join("crates")).unwrap() {
        let source = entry.unwrap().path().join("src");
        for root in ["lib.rs", "main.rs"].map(|root| source.join(root)) {
            if root.exists() {
                let name = source.parent().unwrap().file_name().unwrap().to_string_lossy().into_owned();
                faults.extend(import_cycles(&root).into_iter().map(|fault| format!("{name}: {fault}")));
            }
        }
    }
    faults.sort();
    assert!(faults.is_empty(), "import cycles:\n{}", faults.join("\n"));
}

#[test]
fn public_items_are_listed() {
    for name in
        ["sim", "recording", "robot", "learned", "scan", "campaign", "export", "inspect", "report", "server"]
    {
        let name = format!("nextview-{name}");
        check_public_items(&workspace().join("crates").join(&name).to_string_lossy(), &name);
    }
}
