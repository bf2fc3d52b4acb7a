use std::fs;
use std::path::{Path, PathBuf};
use syn::{Attribute, Item, UseTree, Visibility};

/// The modules of a crate, without its tests.
pub(crate) struct Sources {
    /// Modules, the root first.
    pub modules: Vec<Module>,
}

/// A module: a file, or a part of one.
pub(crate) struct Module {
    /// Path from the root of the crate; empty for the root itself.
    pub path: Vec<String>,
    pub file: PathBuf,
    pub items: Vec<Item>,
    pub imports: Vec<Import>,
    /// Names of the modules it declares as public.
    pub public_modules: Vec<String>,
}

/// A name that a `use` brings into a module.
#[derive(Clone, Debug)]
pub(crate) struct Import {
    /// The name; `*` for a glob.
    pub name: String,
    /// The path as written.
    pub path: Vec<String>,
    pub is_public: bool,
}

/// The place where an item is defined.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Definition {
    /// Index of the module.
    pub module: usize,
    /// `None` for the module itself.
    pub item: Option<String>,
}

impl Sources {
    /// Reads the crate whose root is this file.
    ///
    /// # Panics
    /// If a file cannot be read or parsed.
    pub fn read(root: &Path) -> Self {
        let mut modules = Vec::new();
        read_file(root, Vec::new(), root.parent().expect("a file is in a folder"), &mut modules);
        Self { modules }
    }

    /// Resolves a path written in a module to the item, or to the module if it names one; `None` for other
    /// crates and for names without a definition.
    pub fn resolve(&self, from: usize, path: &[String]) -> Option<Definition> {
        self.resolve_within(from, path, 0)
    }

    fn resolve_within(&self, from: usize, path: &[String], depth: usize) -> Option<Definition> {
        if depth > 20 {
            return None;
        }
        let (first, rest) = path.split_first()?;
        let own = &self.modules[from].path;
        match first.as_str() {
            "crate" => self.walk(0, rest, depth),
            "self" => self.walk(from, rest, depth),
            "super" => {
                let parent = self.module(own.split_last()?.1)?;
                match rest.first().is_some_and(|next| next == "super") {
                    true => self.resolve_within(parent, rest, depth + 1),
                    false => self.walk(parent, rest, depth),
                }
            }
            _ => self.walk(from, path, depth),
        }
    }

    fn walk(&self, module: usize, path: &[String], depth: usize) -> Option<Definition> {
        let Some((name, rest)) = path.split_first() else { return Some(Definition { module, item: None }) };
        let child = self.module(&[&self.modules[module].path[..], std::slice::from_ref(name)].concat());
        if let (Some(child), false) = (child, rest.is_empty()) {
            return self.walk(child, rest, depth);
        }
        if self.modules[module].defines(name) {
            return Some(Definition { module, item: Some(name.clone()) });
        }
        // The last name of a path may be both a function's and a module's, and then the function is meant.
        match (self.imported(module, name, depth), child) {
            (Some(found), _) if found.item.is_some() => Some(found), // also `Type::function`
            (_, Some(child)) => self.walk(child, rest, depth),
            (Some(found), None) => self.walk(found.module, rest, depth + 1),
            (None, None) => None,
        }
    }

    /// Returns the item or module of this name that a module imports.
    fn imported(&self, module: usize, name: &str, depth: usize) -> Option<Definition> {
        let import = self.modules[module].imports.iter().find(|import| import.name == name)?;
        self.resolve_within(module, &import.path, depth + 1)
    }

    pub fn module(&self, path: &[String]) -> Option<usize> {
        self.modules.iter().position(|module| module.path == path)
    }
}

impl Module {
    fn defines(&self, name: &str) -> bool {
        self.items.iter().filter_map(item_name).any(|own| own == name)
    }
}

/// The name of an item, if any; `None` for modules.
pub(crate) fn item_name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

/// Whether an item is only for tests or for the fuzzer.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || (attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Path>().is_ok_and(is_absent))
    })
}

/// Whether the condition is false in the program's build.
fn is_absent(condition: syn::Path) -> bool {
    condition.is_ident("test") || condition.is_ident("fuzzing")
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn read_file(file: &Path, path: Vec<String>, children: &Path, modules: &mut Vec<Module>) {
    let text = fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let syntax = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    add(file, path, children, syntax.items, modules);
}

/// Adds a module and its submodules, whose files are in `children`.
fn add(file: &Path, path: Vec<String>, children: &Path, items: Vec<Item>, modules: &mut Vec<Module>) {
    let items: Vec<Item> = items.into_iter().filter(|item| !is_test(attributes(item))).collect();
    let (inner, items): (Vec<Item>, Vec<Item>) =
        items.into_iter().partition(|item| matches!(item, Item::Mod(_)));
    let mut imports = Vec::new();
    for item in &items {
        if let Item::Use(item) = item {
            let is_public = matches!(item.vis, Visibility::Public(_));
            add_imports(&item.tree, &mut Vec::new(), is_public, &mut imports);
        }
    }
    let is_public =
        |item: &&Item| matches!(item, Item::Mod(module) if matches!(module.vis, Visibility::Public(_)));
    let public_modules = inner.iter().filter(is_public).filter_map(module_name).collect();
    modules.push(Module { path: path.clone(), file: file.to_owned(), items, imports, public_modules });
    for item in inner {
        let Item::Mod(module) = item else { continue };
        let name = module.ident.to_string();
        let (path, folder) = ([&path[..], std::slice::from_ref(&name)].concat(), children.join(&name));
        match module.content {
            Some((_, items)) => add(file, path, &folder, items, modules),
            None if folder.join("mod.rs").exists() => {
                read_file(&folder.join("mod.rs"), path, &folder, modules);
            }
            None => read_file(&children.join(format!("{name}.rs")), path, &folder, modules),
        }
    }
}

fn module_name(item: &Item) -> Option<String> {
    match item {
        Item::Mod(module) => Some(module.ident.to_string()),
        _ => None,
    }
}

fn add_imports(tree: &UseTree, path: &mut Vec<String>, is_public: bool, imports: &mut Vec<Import>) {
    let mut add = |name: String, last: Option<String>| {
        let path = path.iter().cloned().chain(last.filter(|last| last != "self")).collect();
        imports.push(Import { name, path, is_public });
    };
    match tree {
        UseTree::Name(name) if name.ident == "self" => {
            let name = path.last().cloned().unwrap_or_default();
            add(name, None);
        }
        UseTree::Name(name) => add(name.ident.to_string(), Some(name.ident.to_string())),
        UseTree::Rename(rename) => add(rename.rename.to_string(), Some(rename.ident.to_string())),
        UseTree::Glob(_) => add("*".to_owned(), None),
        UseTree::Path(inner) => {
            path.push(inner.ident.to_string());
            add_imports(&inner.tree, path, is_public, imports);
            path.pop();
        }
        UseTree::Group(group) => {
            group.items.iter().for_each(|tree| add_imports(tree, path, is_public, imports));
        }
    }
}
