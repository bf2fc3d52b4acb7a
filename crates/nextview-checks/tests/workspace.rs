//! The crates are layers, no crate has import cycles between its files, and all lock files agree.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview_checks::{check_public_items, import_cycles, upward_dependencies};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// From low to high; crates on one line know nothing of each other.
const LAYERS: [&[&str]; 9] = [
    &["nextview", "nextview-checks"],
    &["nextview-model", "nextview-octomap"],
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
    let crates = fs::read_dir(workspace().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let others = ["benchmarks", "evidence", "python", "training"].map(|name| workspace().join(name));
    for source in crates.chain(others).map(|folder| folder.join("src")) {
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
    for name in [
        "model",
        "octomap",
        "sim",
        "recording",
        "robot",
        "learned",
        "scan",
        "campaign",
        "export",
        "inspect",
        "report",
        "server",
    ] {
        let name = format!("nextview-{name}");
        check_public_items(&workspace().join("crates").join(&name).to_string_lossy(), &name);
    }
}

/// The names in the first column of the first table after this heading of ARCHITECTURE.md.
fn architecture(heading: &str) -> Vec<String> {
    let text = fs::read_to_string(workspace().join("ARCHITECTURE.md")).unwrap();
    let (_, section) = text.split_once(heading).unwrap();
    let table =
        section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    table.skip(2).map(|row| row.split('`').nth(1).unwrap().to_owned()).collect()
}

#[test]
fn architecture_lists_every_crate_from_top_to_bottom() {
    let listed = architecture("\n## Crates\n");
    let rank = |name: &String| LAYERS.iter().position(|layer| layer.contains(&name.as_str())).unwrap();
    assert!(listed.iter().rev().is_sorted_by_key(rank), "{listed:?}");
    let crates = LAYERS.concat().into_iter().filter(|name| *name != "nextview-checks");
    assert_eq!(BTreeSet::from_iter(listed.iter().map(String::as_str)), crates.collect());
}

#[test]
fn architecture_lists_every_layer_of_the_planning_library() {
    let folders = fs::read_dir(workspace().join("crates/nextview/src")).unwrap().map(Result::unwrap);
    let folders = folders.filter(|entry| entry.path().is_dir());
    let folders: BTreeSet<_> = folders.map(|entry| entry.file_name().into_string().unwrap()).collect();
    assert_eq!(BTreeSet::from_iter(architecture("\n## The planning library\n")), folders);
}

#[test]
fn the_walks_of_architecture_lead_through_existing_files_and_never_back() {
    let text = fs::read_to_string(workspace().join("ARCHITECTURE.md")).unwrap();
    let (_, section) = text.split_once("\n## Six walks\n").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let walks: Vec<&str> = section.split("\n**").skip(1).collect();
    assert_eq!(walks.len(), 6);
    for walk in walks {
        let steps = walk.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
        let files: Vec<&str> = steps.map(|step| step.split('`').nth(1).unwrap()).collect();
        for file in &files {
            assert!(workspace().join("crates").join(file).is_file(), "{file} does not exist");
        }
        assert_eq!(BTreeSet::from_iter(&files).len(), files.len(), "returns to a file:{walk}");
    }
}

/// `cargo test` runs packages in the order of their names, and the last one prints what was skipped.
#[test]
fn the_summary_of_skipped_tests_comes_last() {
    let text = fs::read_to_string(workspace().join("Cargo.toml")).unwrap();
    let manifest: toml::Table = text.parse().unwrap();
    let members = manifest["workspace"]["members"].as_array().unwrap();
    let name = |member: &toml::Value| {
        let path = workspace().join(member.as_str().unwrap()).join("Cargo.toml");
        let package: toml::Table = fs::read_to_string(path).unwrap().parse().unwrap();
        package["package"]["name"].as_str().unwrap().to_owned()
    };
    assert_eq!(members.iter().map(name).max().as_deref(), Some("nextview-training"));
    assert!(workspace().join("training/tests/skipped.rs").exists());
}

/// The versions of each package that the lock file of a folder names.
fn locked(folder: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string(workspace().join(folder).join("Cargo.lock")).unwrap();
    let lock: toml::Table = text.parse().unwrap();
    let mut versions = BTreeMap::<String, BTreeSet<String>>::new();
    for package in lock["package"].as_array().unwrap() {
        let text = |key: &str| package[key].as_str().unwrap().to_owned();
        versions.entry(text("name")).or_default().insert(text("version"));
    }
    versions
}

/// What is fuzzed, and what Python runs, is what the tests have tested.
#[test]
fn workspaces_beside_this_one_lock_the_same_versions() {
    let ours = locked(".");
    let mut faults = Vec::new();
    for folder in ["examples/own_camera", "fuzz", "python"] {
        for (name, versions) in locked(folder) {
            if let Some(ours) = ours.get(&name).filter(|ours| !versions.is_subset(ours)) {
                faults.push(format!("{folder}: {name} {versions:?}, in the workspace {ours:?}"));
            }
        }
    }
    let help = "in that folder: cargo update -p NAME --precise VERSION";
    assert!(faults.is_empty(), "{}\n{help}", faults.join("\n"));
}
