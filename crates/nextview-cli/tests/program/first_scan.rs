//! The output shown in docs/scan.md and docs/start.md is what their commands print, except for times and
//! memory.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::process::Command;

/// Lines that may differ between machines.
const MEASURED: [&str; 5] = ["planning time", "map update", "baselines took", "peak memory", "results in"];

/// The words of each line without measured ones.
fn lines(text: &str) -> Vec<Vec<&str>> {
    let stable = text.lines().filter(|line| !MEASURED.iter().any(|label| line.starts_with(label)));
    let words = stable.map(|line| {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        if let Some(unit) = words.iter().position(|word| *word == "ms") {
            words.remove(unit - 1);
        }
        words
    });
    words.filter(|words| !words.is_empty()).collect()
}

/// What the program prints with these arguments.
fn printed(arguments: &str, name: &str) -> String {
    let folder = std::env::temp_dir().join(format!("nextview-{name}-{}", std::process::id()));
    let out = folder.to_string_lossy();
    let mut command = Command::new(env!("CARGO_BIN_EXE_nextview"));
    let output = command.args(arguments.split(' ')).args(["--out", &*out]).output().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

/// The first block of a page that shows text.
fn shown(page: &str) -> &str {
    page.split("```text\n").nth(1).unwrap().split("```").next().unwrap()
}

#[test]
fn shows_what_the_first_command_prints() {
    let printed = printed("scan", "first-scan");
    let page = include_str!("../../../../docs/scan.md");
    assert_eq!(lines(shown(page)), lines(&printed), "docs/scan.md shows another output");
}

#[test]
fn the_start_shows_lines_that_its_command_prints() {
    let page = include_str!("../../../../docs/start.md");
    let command = page.lines().find_map(|line| line.strip_prefix("nextview scan builtin:mug ")).unwrap();
    let printed =
        printed(&format!("scan builtin:mug {}", command.strip_suffix(" --out mug").unwrap()), "start");
    let printed = lines(&printed);
    for line in lines(shown(page)) {
        assert!(printed.contains(&line), "docs/start.md shows another output: {line:?}");
    }
}
