use crate::sources::{Definition, Sources};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use syn::visit::{self, Visit};
use syn::{Item, Macro, Path};

/// For each file, the files whose definitions it uses, with an example of each use.
pub(crate) type Edges = BTreeMap<PathBuf, BTreeMap<PathBuf, String>>;

/// All uses between the files of a crate.
///
/// Modules that only re-export (`pub use`) use nothing.
pub(crate) fn edges(sources: &Sources) -> Edges {
    let mut edges = Edges::new();
    for (index, module) in sources.modules.iter().enumerate() {
        let paths = used_paths(sources, index);
        for (path, found) in paths.into_iter().filter_map(|path| Some((sources.resolve(index, &path)?, path)))
        {
            let Definition { module: target, item } = path;
            let file = &sources.modules[target].file;
            // A module is named to reach its items, which count by themselves.
            if item.is_some() && *file != module.file {
                let uses = edges.entry(module.file.clone()).or_default();
                uses.entry(file.clone()).or_insert_with(|| found.join("::"));
            }
        }
    }
    edges
}

/// The paths used by a module: those of private imports, and those at the start of its code's paths.
pub(crate) fn used_paths(sources: &Sources, module: usize) -> BTreeSet<Vec<String>> {
    let module = &sources.modules[module];
    let mut names = ModuleNames::default();
    module.items.iter().filter(|item| !matches!(item, Item::Use(_))).for_each(|item| names.visit_item(item));
    let private = module.imports.iter().filter(|import| !import.is_public);
    names.paths.extend(private.map(|import| import.path.clone()));
    names.paths
}

#[derive(Default)]
struct ModuleNames {
    paths: BTreeSet<Vec<String>>,
}

impl<'a> Visit<'a> for ModuleNames {
    fn visit_path(&mut self, path: &'a Path) {
        if path.leading_colon.is_none() {
            self.paths.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'a Macro) {
        let text = item.tokens.to_string().replace(" :: ", "::");
        let is_other = |c: char| !(c.is_alphanumeric() || c == '_' || c == ':');
        for word in text.split(is_other).filter(|word| !word.is_empty()) {
            let path: Vec<String> =
                word.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
            self.paths.insert(path);
        }
        visit::visit_macro(self, item);
    }
}
