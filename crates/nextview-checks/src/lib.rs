//! Checks of the sources of all crates, for their tests: [layers](upward_imports) of modules, [import
//! cycles](import_cycles) between files, [layers of crates](upward_dependencies), and [lists of public
//! items](check_public_items). They read syntax only; nothing is compiled. Tests (`#[cfg(test)]`) are left
//! out.
//!
//! Also the common parts of all crates' tests: how they are [skipped], and the place of their [data].

mod crate_layers;
mod cycles;
mod edges;
mod layers;
mod lister;
mod public_items;
mod skipped;
mod sources;
mod text;

pub use crate_layers::upward_dependencies;
pub use cycles::import_cycles;
pub use layers::upward_imports;
pub use lister::public_items;
pub use public_items::check_public_items;
pub use skipped::{data, skipped, take_skipped};

/// Tests the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/library.md")]
struct Library;
