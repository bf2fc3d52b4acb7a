use crate::lister::public_items;
use std::path::Path;
use std::{env, fs};

/// Variable that, if set to 1, rewrites the lists of public items.
const WRITE: &str = "NEXTVIEW_WRITE_PUBLIC_ITEMS";

/// Compares the public items of a crate with the list in its folder, `public-items.txt`, or writes that list
/// if `NEXTVIEW_WRITE_PUBLIC_ITEMS=1` is set in the environment.
///
/// # Panics
/// If they differ: a change of the interface must be visible in the list.
pub fn check_public_items(manifest_dir: &str, name: &str) {
    let folder = Path::new(manifest_dir);
    let (root, list) = (folder.join("src/lib.rs"), folder.join("public-items.txt"));
    let found = public_items(&root, name).join("\n") + "\n";
    if env::var(WRITE).is_ok_and(|value| value == "1") {
        fs::write(&list, &found).unwrap_or_else(|e| panic!("{}: {e}", list.display()));
        return;
    }
    let listed = fs::read_to_string(&list).unwrap_or_default();
    let missing = difference(&found, &listed, '+');
    let stale = difference(&listed, &found, '-');
    assert!(
        found == listed,
        "the public items of {name} differ from public-items.txt; if that is meant, run\n    \
         {WRITE}=1 cargo test -p {name} -p {} public_items_are_listed\n{missing}{stale}",
        env!("CARGO_PKG_NAME")
    );
}

fn difference(of: &str, without: &str, sign: char) -> String {
    let known: std::collections::BTreeSet<&str> = without.lines().collect();
    of.lines().filter(|line| !known.contains(line)).map(|line| format!("{sign} {line}\n")).collect()
}
