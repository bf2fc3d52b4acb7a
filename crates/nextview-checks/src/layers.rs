use crate::edges::used_paths;
use crate::sources::Sources;
use std::path::Path;

/// Returns the imports of a crate's top-level modules that do not point down, one line each.
///
/// `layers` lists the modules from low to high; modules in the same layer must not import each other. The
/// root module is not checked.
///
/// # Panics
/// If a file cannot be read or parsed, or a module has no layer.
pub fn upward_imports(root: &Path, layers: &[&[&str]]) -> Vec<String> {
    let sources = Sources::read(root);
    let layer = |module: &str| {
        let found = layers.iter().position(|layer| layer.contains(&module));
        found.unwrap_or_else(|| panic!("module {module} has no layer"))
    };
    let mut faults = Vec::new();
    for (index, module) in sources.modules.iter().enumerate() {
        let Some(own) = module.path.first() else { continue };
        let paths = used_paths(&sources, index).into_iter().map(|path| sources.resolve(index, &path));
        let targets = paths.flatten().filter_map(|found| sources.modules[found.module].path.first());
        for target in targets.filter(|target| *target != own && layer(target) >= layer(own)) {
            faults.push(format!("{}: {own} imports {target}", module.path.join("::")));
        }
    }
    faults.dedup();
    faults
}
