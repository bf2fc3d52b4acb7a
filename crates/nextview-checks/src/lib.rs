//! Checks of the sources of all crates, for their tests: [layers](upward_imports) of modules, [import
//! cycles](import_cycles) between files, [layers of crates](upward_dependencies), and [lists of public
//! items](check_public_items).
//!
//! All checks read syntax alone; nothing is compiled. Tests (`#[cfg(test)]`) are left out.

mod crate_layers;
mod cycles;
mod edges;
mod layers;
mod lister;
mod public_items;
mod sources;
mod text;

pub use crate_layers::upward_dependencies;
pub use cycles::import_cycles;
pub use layers::upward_imports;
pub use lister::public_items;
pub use public_items::check_public_items;

/// The examples of the documentation, kept working.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/library.md")]
struct Library;
