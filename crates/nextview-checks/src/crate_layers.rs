use crate::edges::used_paths;
use crate::sources::Sources;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the dependencies between the crates of a workspace that do not point down, one line for each that
/// a manifest or the sources name.
///
/// `layers` lists the crates from low to high; crates in the same layer must not depend on each other. Listed
/// crates that do not exist are skipped. Dependencies only for tests may point anywhere.
///
/// # Panics
/// If a manifest cannot be read, or a crate in `workspace/crates` has no layer.
pub fn upward_dependencies(workspace: &Path, layers: &[&[&str]]) -> Vec<String> {
    let layer = |name: &str| layers.iter().position(|layer| layer.contains(&name));
    let mut faults = Vec::new();
    for folder in folders(&workspace.join("crates")) {
        let manifest = manifest(&folder);
        let name = manifest["package"]["name"].as_str().expect("a package has a name").to_owned();
        let own = layer(&name).unwrap_or_else(|| panic!("the crate {name} has no layer"));
        let mut check = |used: &str, place: &str| {
            if used != name && layer(used).is_some_and(|layer| layer >= own) {
                faults.push(format!("{name} depends on {used} ({place})"));
            }
        };
        for used in manifest.get("dependencies").and_then(toml::Value::as_table).into_iter().flatten() {
            check(used.0, "Cargo.toml");
        }
        for root in ["src/lib.rs", "src/main.rs"].map(|root| folder.join(root)) {
            if root.exists() {
                let sources = Sources::read(&root);
                for module in 0..sources.modules.len() {
                    for path in used_paths(&sources, module) {
                        let name = path.first().map_or(String::new(), |name| name.replace('_', "-"));
                        check(&name, &sources.modules[module].path.join("::"));
                    }
                }
            }
        }
    }
    faults
}

fn folders(parent: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(parent).unwrap_or_else(|e| panic!("{}: {e}", parent.display()));
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.retain(|folder| folder.join("Cargo.toml").exists());
    folders.sort();
    folders
}

fn manifest(folder: &Path) -> toml::Table {
    let path = folder.join("Cargo.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
