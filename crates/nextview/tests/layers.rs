//! The library's modules are layers; this test reads their `use` lines and fails on an upward import.

#![allow(clippy::unwrap_used, reason = "helpers of a test")]

use std::fs;
use std::path::{Path, PathBuf};

/// From low to high; modules on one line know nothing of each other.
const LAYERS: [&[&str]; 9] = [
    &["error"],
    &["geometry", "flow"],
    &["sensor"],
    &["map"],
    &["view", "model", "prior", "registration"],
    &["visibility", "motion"],
    &["gain"],
    &["planner"],
    &["session"],
];

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The top-level modules that a source text names after `crate::`, tests and doc examples aside.
fn imports(text: &str) -> Vec<String> {
    let code: String = text
        .split("#[cfg(test)]")
        .next()
        .unwrap()
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join(" ");
    let mut modules = Vec::new();
    for part in code.split("crate::").skip(1) {
        match part.strip_prefix('{') {
            // `use crate::{Error, geometry::Pose}`: every word that begins an element.
            Some(group) => {
                let mut depth = 0;
                let mut word = String::new();
                for c in group.chars() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => modules.push(std::mem::take(&mut word)),
                        c if depth == 0 => word.push(c),
                        _ => {}
                    }
                }
                modules.push(word);
            }
            None => modules.push(part.to_owned()),
        }
    }
    let first_word = |path: String| {
        path.trim().chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect::<String>()
    };
    modules.into_iter().map(first_word).filter(|word| !word.is_empty()).collect()
}

#[test]
fn imports_point_down_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut n_checked = 0;
    let mut faults = Vec::new();
    for file in files {
        let relative = file.strip_prefix(&root).unwrap().to_path_buf();
        let module = relative.components().next().unwrap().as_os_str().to_string_lossy().replace(".rs", "");
        if module == "lib" {
            continue;
        }
        let own = layer(&module).unwrap_or_else(|| panic!("module {module} has no layer: add it to LAYERS"));
        for import in imports(&fs::read_to_string(&file).unwrap()) {
            // `Error` is re-exported at the root.
            let import = if import == "Error" { "error".to_owned() } else { import };
            let target = layer(&import).unwrap_or_else(|| panic!("{relative:?}: unknown module {import}"));
            n_checked += 1;
            if target >= own && import != module {
                faults.push(format!("{}: {module} imports {import}", relative.display()));
            }
        }
    }
    assert!(faults.is_empty(), "upward imports:\n{}", faults.join("\n"));
    assert!(n_checked > 50, "only {n_checked} imports found: the reader of `use` lines is broken");
}

#[test]
fn the_reader_finds_imports_in_every_form() {
    let text = "use crate::{Error, map::{A, B}, view::C};\nuse crate::flow::X;\nlet y = crate::gain::z();\n// crate::no";
    assert_eq!(imports(text), ["Error", "map", "view", "flow", "gain"]);
}
