//! The library's modules are layers, and its files import each other without cycles.

use nextview_checks::{import_cycles, upward_imports};
use std::path::Path;

/// From low to high; modules on one line know nothing of each other.
const LAYERS: [&[&str]; 11] = [
    &["cancel"],
    &["error"],
    &["checked", "degrees", "instructions", "text"],
    &["geometry", "flow"],
    &["sensor"],
    &["map", "diagnosis"],
    &["view", "surface", "prior", "registration", "object"],
    &["visibility", "motion"],
    &["gain"],
    &["planner", "placement"],
    &["session"],
];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src/lib.rs"))
}

#[test]
fn imports_point_down_only() {
    let faults = upward_imports(root(), &LAYERS);
    assert!(faults.is_empty(), "upward imports:\n{}", faults.join("\n"));
}

#[test]
fn files_import_each_other_without_cycles() {
    let faults = import_cycles(root());
    assert!(faults.is_empty(), "import cycles:\n{}", faults.join("\n"));
}
