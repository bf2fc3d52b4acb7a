//! Checks of the sources of all crates, for their tests: [layers](upward_imports) of modules, [import
//! cycles](import_cycles) between files, [layers of crates](upward_dependencies), and [lists of public
//! items](check_public_items). They read syntax alone; nothing is compiled. Tests (`#[cfg(test)]`) are left
//! out.
//!
//! And what tests of all crates share: how they are [skipped], and where their [data] is.

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

/// The examples of the documentation, kept working.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/library.md")]
struct Library;
