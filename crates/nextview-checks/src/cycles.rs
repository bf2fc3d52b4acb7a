use crate::edges::{Edges, edges};
use crate::sources::Sources;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Returns the uses between files of a crate that are part of a cycle, direct or indirect, one line each.
///
/// `root` is the crate's `lib.rs` or `main.rs`. A file that only re-exports items of another one does not use
/// it.
///
/// # Panics
/// If a file cannot be read or parsed.
pub fn import_cycles(root: &Path) -> Vec<String> {
    let edges = edges(&Sources::read(root));
    let folder = root.parent().expect("a file is in a folder");
    let name = |file: &Path| file.strip_prefix(folder).unwrap_or(file).display().to_string();
    let mut faults = Vec::new();
    for (file, uses) in &edges {
        for (target, path) in uses {
            if reached(&edges, target).contains(file) {
                faults.push(format!("{} uses {} ({path})", name(file), name(target)));
            }
        }
    }
    faults
}

/// All files that a file uses, directly or indirectly.
fn reached(edges: &Edges, from: &Path) -> BTreeSet<PathBuf> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from.to_owned()]);
    while let Some(file) = open.pop() {
        for target in edges.get(&file).into_iter().flat_map(|uses| uses.keys()) {
            if found.insert(target.clone()) {
                open.push(target.clone());
            }
        }
    }
    found
}
