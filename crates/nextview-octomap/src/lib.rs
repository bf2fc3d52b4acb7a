//! OctoMap's octree files, `.ot` and `.bt`, read and written byte for byte as OctoMap does
//! (Hornung et al. 2013; checked against the tools of OctoMap 1.9.7).
//!
//! Start with [`Octree`]. It is an immutable copy of a file: measurements go into a map, and the octree only
//! exchanges that map with OctoMap. Time stamps and OctoMap's other tree types are not supported.

mod bt;
mod build;
mod convert;
mod header;
mod node_reader;
mod nodes;
mod ot;
mod preorder;
mod prune;
mod read;
mod source;
#[cfg(test)]
mod tests;
mod tree;

pub use tree::{Leaf, Octree, TreeKind};
