use crate::sources::{Definition, Sources, item_name};
use crate::text::text;
use std::collections::BTreeSet;
use std::path::Path;
use syn::{Attribute, Fields, ImplItem, Item, ItemImpl, TraitItem, Type, Visibility};

/// Returns all public items of a crate, sorted, one per line: path and signature.
///
/// Items are modules, functions, constants, types with their derives, fields, variants and methods, traits
/// with their items, implementations of traits, and re-exports of other crates. `root` is the crate's
/// `lib.rs`, `name` its name.
///
/// # Panics
/// If a file cannot be read or parsed.
pub fn public_items(root: &Path, name: &str) -> Vec<String> {
    let mut lister = Lister { sources: Sources::read(root), lines: BTreeSet::new(), listed: BTreeSet::new() };
    lister.module(0, name);
    lister.lines.into_iter().collect()
}

struct Lister {
    sources: Sources,
    lines: BTreeSet<String>,
    /// Listed items, with the paths of their entries.
    listed: BTreeSet<(Definition, String)>,
}

impl Lister {
    fn module(&mut self, module: usize, path: &str) {
        let found = &self.sources.modules[module];
        let items = found.items.iter().filter(|item| is_public(item)).filter_map(item_name);
        let own: Vec<Definition> = items.map(|item| Definition { module, item: Some(item) }).collect();
        let imports: Vec<_> = found.imports.iter().filter(|import| import.is_public).cloned().collect();
        let children = found.public_modules.clone();
        for definition in own {
            self.definition(&definition, path);
        }
        for import in imports {
            match self.sources.resolve(module, &import.path) {
                Some(definition @ Definition { item: Some(_), .. }) => self.definition(&definition, path),
                Some(Definition { module, item: None }) => {
                    self.module(module, &format!("{path}::{}", import.name));
                }
                None => self.add(path, &format!("pub use {}", import.path.join("::"))),
            }
        }
        for child in children {
            let child_path = [&self.sources.modules[module].path[..], std::slice::from_ref(&child)].concat();
            if let Some(index) = self.sources.module(&child_path) {
                self.add(path, &format!("pub mod {child}"));
                self.module(index, &format!("{path}::{child}"));
            }
        }
    }

    fn add(&mut self, path: &str, signature: &str) {
        self.lines.insert(format!("{path}: {signature}"));
    }

    fn definition(&mut self, definition: &Definition, path: &str) {
        if !self.listed.insert((definition.clone(), path.to_owned())) {
            return;
        }
        let Some(name) = &definition.item else { return };
        let items = self.sources.modules[definition.module].items.clone();
        for item in items.iter().filter(|item| item_name(item).as_ref() == Some(name)) {
            self.item(item, path, name);
        }
        self.implementations(definition, &format!("{path}::{name}"));
    }

    fn item(&mut self, item: &Item, path: &str, name: &str) {
        let inner = format!("{path}::{name}");
        match item {
            Item::Const(item) => self.add(path, &format!("pub const {name}: {}", text(&item.ty))),
            Item::Static(item) => self.add(path, &format!("pub static {name}: {}", text(&item.ty))),
            Item::Fn(item) => self.add(path, &format!("pub {}", text(&item.sig))),
            Item::Type(item) => self.add(path, &format!("pub type {name} = {}", text(&item.ty))),
            Item::Struct(item) => {
                let traits = attributes(&item.attrs);
                self.add(path, &format!("{traits}pub struct {name}{}", text(&item.generics)));
                self.fields(&item.fields, &inner, true);
            }
            Item::Enum(item) => {
                let traits = attributes(&item.attrs);
                self.add(path, &format!("{traits}pub enum {name}{}", text(&item.generics)));
                for variant in &item.variants {
                    self.add(&inner, &variant.ident.to_string());
                    self.fields(&variant.fields, &format!("{inner}::{}", variant.ident), false);
                }
            }
            Item::Trait(item) => {
                let bounds = text(&item.supertraits);
                let bounds = if bounds.is_empty() { bounds } else { format!(": {bounds}") };
                self.add(path, &format!("pub trait {name}{}{bounds}", text(&item.generics)));
                item.items.iter().for_each(|item| self.trait_item(item, &inner));
            }
            _ => {}
        }
    }

    fn fields(&mut self, fields: &Fields, path: &str, asks_visibility: bool) {
        for (number, field) in fields.iter().enumerate() {
            if !asks_visibility || matches!(field.vis, Visibility::Public(_)) {
                let name = field.ident.as_ref().map_or(number.to_string(), ToString::to_string);
                self.add(path, &format!("{name}: {}", text(&field.ty)));
            }
        }
    }

    fn trait_item(&mut self, item: &TraitItem, path: &str) {
        match item {
            TraitItem::Fn(item) => {
                let default = if item.default.is_some() { " { .. }" } else { "" };
                self.add(path, &format!("{}{default}", text(&item.sig)));
            }
            TraitItem::Const(item) => self.add(path, &format!("const {}: {}", item.ident, text(&item.ty))),
            TraitItem::Type(item) => self.add(path, &text(item).replace(';', "")),
            _ => {}
        }
    }

    /// Methods, and traits that are not derived.
    fn implementations(&mut self, definition: &Definition, path: &str) {
        let mut found: Vec<ItemImpl> = Vec::new();
        for (index, module) in self.sources.modules.iter().enumerate() {
            let all = module.items.iter().filter_map(|item| match item {
                Item::Impl(item) => Some(item),
                _ => None,
            });
            let is_own = |item: &&ItemImpl| {
                type_path(&item.self_ty).and_then(|path| self.sources.resolve(index, &path)).as_ref()
                    == Some(definition)
            };
            found.extend(all.filter(is_own).cloned());
        }
        for item in found {
            match &item.trait_ {
                Some((_, name, _)) => {
                    self.add(path, &format!("impl {} for {}", text(name), text(&item.self_ty)));
                }
                None => item.items.iter().for_each(|item| self.impl_item(item, path)),
            }
        }
    }

    fn impl_item(&mut self, item: &ImplItem, path: &str) {
        match item {
            ImplItem::Fn(item) if matches!(item.vis, Visibility::Public(_)) => {
                self.add(path, &format!("pub {}", text(&item.sig)));
            }
            ImplItem::Const(item) if matches!(item.vis, Visibility::Public(_)) => {
                self.add(path, &format!("pub const {}: {}", item.ident, text(&item.ty)));
            }
            _ => {}
        }
    }
}

fn type_path(ty: &Type) -> Option<Vec<String>> {
    match ty {
        Type::Path(ty) => Some(ty.path.segments.iter().map(|segment| segment.ident.to_string()).collect()),
        Type::Reference(ty) => type_path(&ty.elem),
        _ => None,
    }
}

fn is_public(item: &Item) -> bool {
    let visibility = match item {
        Item::Const(item) => &item.vis,
        Item::Enum(item) => &item.vis,
        Item::Fn(item) => &item.vis,
        Item::Static(item) => &item.vis,
        Item::Struct(item) => &item.vis,
        Item::Trait(item) => &item.vis,
        Item::Type(item) => &item.vis,
        _ => return false,
    };
    matches!(visibility, Visibility::Public(_))
}

/// The attributes that are part of the interface: derives, and whether variants or fields may be added.
fn attributes(attributes: &[Attribute]) -> String {
    let is_part = |attribute: &&Attribute| {
        ["derive", "non_exhaustive"].iter().any(|name| attribute.path().is_ident(name))
    };
    attributes.iter().filter(is_part).map(|attribute| text(attribute) + " ").collect()
}
