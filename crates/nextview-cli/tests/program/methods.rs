//! The pages in docs/methods are complete and name only what exists: there is a page for every planner, and
//! the files, tests and options exist.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::PathBuf;

/// Another test checks that this equals the output of the program.
const HELP: &str = include_str!("help/nextview-scan.txt");

fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Name and text of every page but the index.
fn pages() -> Vec<(String, String)> {
    let read = |entry: fs::DirEntry| {
        (entry.file_name().into_string().unwrap(), fs::read_to_string(entry.path()).unwrap())
    };
    let folder = fs::read_dir(workspace().join("docs/methods")).unwrap();
    folder.map(|entry| read(entry.unwrap())).filter(|(name, _)| name != "README.md").collect()
}

/// Every second part of a page cut at backticks is a quotation; the formulas, in three backticks, are left
/// out.
fn quotations(page: &str) -> Vec<String> {
    let prose: String = page.split("```").step_by(2).collect();
    prose.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn source(page: &str, path: &str) -> String {
    fs::read_to_string(workspace().join(path)).unwrap_or_else(|e| panic!("{page} names {path}: {e}"))
}

#[test]
fn every_planner_has_a_page_that_says_how_to_call_it() {
    let values = HELP.split("--planner <PLANNER>").nth(1).unwrap().split("--theta").next().unwrap();
    let names: Vec<&str> = values
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix("- ")?.split_once(':'))
        .map(|(name, _)| name)
        .collect();
    assert!(names.len() > 10 && names.contains(&"max-flow") && names.contains(&"clairvoyant"), "{names:?}");
    let readme = fs::read_to_string(workspace().join("README.md")).unwrap();
    assert!(
        readme.contains(&format!("{} planners, two of them bounds", names.len())),
        "{} planners",
        names.len()
    );
    let pages = pages();
    for name in names {
        let page = pages.iter().find(|(page, _)| *page == format!("{name}.md"));
        let (page, text) = page.unwrap_or_else(|| panic!("docs/methods/{name}.md is missing"));
        let call = format!("--planner {name}");
        let calls = |quotation: &String| *quotation == call || quotation.starts_with(&format!("{call} "));
        assert!(quotations(text).iter().any(calls), "{page} does not say `{call}`");
    }
}

#[test]
fn the_index_links_every_page() {
    let index = fs::read_to_string(workspace().join("docs/methods/README.md")).unwrap();
    for (name, _) in pages() {
        assert!(index.contains(&format!("]({name})")), "{name} is not in the index");
    }
}

#[test]
fn files_and_tests_exist() {
    for (name, text) in pages() {
        for path in quotations(&text).iter().filter(|quotation| quotation.starts_with("crates/")) {
            source(&name, path);
        }
        // "`test` in `file`"
        let tests: Vec<(&str, &str)> = text
            .split("` in `")
            .zip(text.split("` in `").skip(1))
            .map(|(before, after)| (before.rsplit('`').next().unwrap(), after.split('`').next().unwrap()))
            .collect();
        assert!(!tests.is_empty(), "{name} names no test");
        for (test, path) in tests.into_iter().filter(|(_, path)| path.starts_with("crates/")) {
            assert!(source(&name, path).contains(&format!("fn {test}(")), "{name}: no {test} in {path}");
        }
    }
}

#[test]
fn options_exist() {
    for (name, text) in pages() {
        let quotations = quotations(&text);
        let options = quotations.iter().flat_map(|quotation| quotation.split(' '));
        for option in options.filter(|word| word.starts_with("--")) {
            assert!(
                HELP.split_whitespace().any(|word| word == option),
                "{name}: nextview scan has no {option}"
            );
        }
    }
}
