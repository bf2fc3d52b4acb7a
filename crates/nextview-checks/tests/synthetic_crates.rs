//! The checks find what they are made to find, in synthetic crates.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview_checks::{import_cycles, public_items, upward_imports};
use std::fs;
use std::path::{Path, PathBuf};

/// Writes files into a folder of their own and returns the path of `lib.rs`.
fn source(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("nextview-checks-{name}-{}", std::process::id()));
    for (file, text) in files {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder.join("lib.rs")
}

fn with<T>(name: &str, files: &[(&str, &str)], check: impl FnOnce(&Path) -> T) -> T {
    let root = source(name, files);
    let found = check(&root);
    fs::remove_dir_all(root.parent().unwrap()).unwrap();
    found
}

#[test]
fn cycles_are_found_through_re_exports() {
    let files = [
        ("lib.rs", "mod a;\n"),
        ("a/mod.rs", "mod b;\nmod c;\npub use b::B;\npub use c::C;\n"),
        ("a/b.rs", "use super::C;\npub struct B(C);\n"),
        ("a/c.rs", "pub struct C;\nimpl C { pub fn b() -> Option<crate::a::B> { None } }\n"),
    ];
    let found = with("cycle", &files, import_cycles);
    assert_eq!(found, ["a/b.rs uses a/c.rs (C)", "a/c.rs uses a/b.rs (crate::a::B)"]);
}

#[test]
fn a_parent_that_only_re_exports_is_no_part_of_a_cycle() {
    let child = ("a/b.rs", "use super::c::C;\npub struct B(C);\n");
    let files = [
        ("lib.rs", "mod a;\n"),
        ("a/mod.rs", "mod b;\nmod c;\npub use b::B;\n"),
        child,
        ("a/c.rs", "pub struct C;\n#[cfg(test)]\nmod tests { use super::super::B; }\n"),
    ];
    assert_eq!(with("tree", &files, import_cycles), [""; 0]);
    // A child that uses what its parent defines, while the parent uses the child.
    let files = [
        ("lib.rs", "mod a;\n"),
        ("a/mod.rs", "mod b;\npub struct A;\nimpl A { fn b(&self) -> b::B { todo!() } }\n"),
        ("a/b.rs", "use super::A;\npub struct B(A);\n"),
    ];
    assert_eq!(with("parent", &files, import_cycles).len(), 2);
}

#[test]
fn a_function_is_found_before_the_module_of_its_name() {
    let files = [
        ("lib.rs", "mod a;\n"),
        ("a/mod.rs", "mod plan;\nmod run;\npub use plan::plan;\npub use run::Run;\n"),
        ("a/plan.rs", "pub fn plan(run: &super::Run) {}\n"),
        ("a/run.rs", "use super::plan;\npub struct Run;\nimpl Run { fn go(&self) { plan(self) } }\n"),
    ];
    let found = with("function", &files, import_cycles);
    assert_eq!(found, ["a/plan.rs uses a/run.rs (super::Run)", "a/run.rs uses a/plan.rs (plan)"]);
}

#[test]
fn upward_imports_are_found() {
    let files = [
        ("lib.rs", "mod low;\nmod high;\npub use low::Fault;\n"),
        ("low.rs", "pub struct Fault;\npub fn f() { crate::high::g() }\n"),
        ("high.rs", "use crate::{Fault, low::f};\npub fn g() -> Fault { f(); Fault }\n"),
    ];
    let found = with("layers", &files, |root| upward_imports(root, &[&["low"], &["high"]]));
    assert_eq!(found, ["low: low imports high"]);
}

#[test]
fn public_items_are_listed_where_they_are_public() {
    let files = [
        ("lib.rs", "mod a;\npub mod b;\npub use a::Shape;\npub use glam;\nfn hidden() {}\n"),
        (
            "a.rs",
            "#[derive(Clone)]\npub struct Shape { pub x: f64, y: f64 }\n\
             impl Shape { pub fn new(x: f64) -> Self { Self { x, y: x } } fn own(&self) {} }\n\
             impl From<f64> for Shape { fn from(x: f64) -> Self { Self::new(x) } }\n\
             pub struct Unreached;\n",
        ),
        (
            "b.rs",
            "pub enum Kind { Plain, Sized(f64) }\npub trait Draw { fn draw(&self, shapes: &[u32]) -> bool; }\n",
        ),
    ];
    let expected = [
        "synthetic: #[derive(Clone)] pub struct Shape",
        "synthetic: pub mod b",
        "synthetic: pub use glam",
        "synthetic::Shape: impl From<f64> for Shape",
        "synthetic::Shape: pub fn new(x: f64) -> Self",
        "synthetic::Shape: x: f64",
        "synthetic::b: pub enum Kind",
        "synthetic::b: pub trait Draw",
        "synthetic::b::Draw: fn draw(&self, shapes: &[u32]) -> bool",
        "synthetic::b::Kind: Plain",
        "synthetic::b::Kind: Sized",
        "synthetic::b::Kind::Sized: 0: f64",
    ];
    assert_eq!(with("items", &files, |root| public_items(root, "synthetic")), expected);
}
