//! Rules for the text of sources and documents.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};

/// The crates that front ends share.
const LIBRARIES: [&str; 8] = [
    "nextview-scan",
    "nextview-campaign",
    "nextview-report",
    "nextview-learned",
    "nextview-recording",
    "nextview-robot",
    "nextview-sim",
    "nextview",
];

/// Characters of a line of prose.
const WIDTH: usize = 110;

/// Code lines of the program: options, progress and printing, and nothing that another front end would need.
const PROGRAM_LINES: usize = 1600;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn files(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            files(&path, extension, found);
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
}

/// The lines of a source before its tests that are neither blank nor comments, with their numbers.
fn code(text: &str) -> Vec<(usize, &str)> {
    let lines = text.lines().take_while(|line| line.trim() != "#[cfg(test)]");
    let is_code = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with("//");
    lines.enumerate().filter(|(_, line)| is_code(line)).map(|(i, line)| (i + 1, line)).collect()
}

#[test]
fn libraries_print_nothing_end_no_process_and_name_no_option() {
    let words = ["println!", "print!", "process::exit", "process::abort", "dbg!", "io::stdout", "io::stderr"];
    let is_option = |line: &str| {
        line.split([' ', '`', '(', '"']).any(|word| {
            word.strip_prefix("--").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
        })
    };
    let mut faults = Vec::new();
    for library in LIBRARIES {
        let mut sources = Vec::new();
        files(&workspace().join("crates").join(library).join("src"), "rs", &mut sources);
        assert!(!sources.is_empty());
        for source in sources.into_iter().filter(|source| !source.ends_with("tests.rs")) {
            let text = fs::read_to_string(&source).unwrap();
            let wrong = |line: &str| words.iter().any(|word| line.contains(word)) || is_option(line);
            let lines = code(&text).into_iter().filter(|(_, line)| wrong(line));
            faults.extend(
                lines.map(|(number, line)| format!("{}:{number}: {}", source.display(), line.trim())),
            );
        }
    }
    assert!(faults.is_empty(), "a front end does that:\n{}", faults.join("\n"));
}

#[test]
fn the_program_is_a_program_and_nothing_else() {
    let mut sources = Vec::new();
    files(&workspace().join("crates/nextview-cli/src"), "rs", &mut sources);
    let lines = |source: &PathBuf| code(&fs::read_to_string(source).unwrap()).len();
    let n_lines: usize = sources.iter().map(lines).sum();
    assert!(n_lines <= PROGRAM_LINES, "{n_lines} code lines, expected at most {PROGRAM_LINES}");
}

#[test]
fn prose_fits_on_a_screen() {
    let mut faults = Vec::new();
    let mut report = |file: &Path, number: usize, line: &str| {
        faults.push(format!("{}:{number}: {} characters", file.display(), line.chars().count()));
    };
    let is_long = |line: &str| line.chars().count() > WIDTH;
    let mut sources = Vec::new();
    files(&workspace(), "rs", &mut sources);
    for source in sources {
        let text = fs::read_to_string(&source).unwrap();
        let mut is_block = false;
        for (i, line) in text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let comment = comment.trim_start_matches(['/', '!']).trim_start();
            is_block ^= comment.starts_with("```");
            if is_long(line) && !is_block && !comment.starts_with('|') && !line.contains("://") {
                report(&source, i + 1, line);
            }
        }
    }
    let mut pages = Vec::new();
    files(&workspace(), "md", &mut pages);
    // Reports that the program writes are data.
    let is_made = |page: &PathBuf| {
        let made = ["docs/planner/", "docs/reproduction/", "golden.md"];
        made.iter().any(|part| page.to_string_lossy().contains(part))
    };
    for page in pages.into_iter().filter(|page| !is_made(page)) {
        let text = fs::read_to_string(&page).unwrap();
        let mut is_block = false;
        for (i, line) in text.lines().enumerate() {
            is_block ^= line.trim_start().starts_with("```");
            let is_prose = !is_block && !line.starts_with("    ") && !line.trim_start().starts_with('|');
            // A link is one word.
            if is_prose && is_long(line) && line.split(' ').all(|word| word.chars().count() < WIDTH / 2) {
                report(&page, i + 1, line);
            }
        }
    }
    assert!(faults.is_empty(), "lines of prose beyond {WIDTH} characters:\n{}", faults.join("\n"));
}
