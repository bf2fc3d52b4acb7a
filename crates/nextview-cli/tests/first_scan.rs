//! The output that docs/scan.md shows is what its first command prints, times and memory aside.

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

#[test]
fn shows_what_the_first_command_prints() {
    let folder = std::env::temp_dir().join(format!("nextview-first-scan-{}", std::process::id()));
    let out = folder.to_string_lossy();
    let output =
        Command::new(env!("CARGO_BIN_EXE_nextview")).args(["scan", "--out", &*out]).output().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(output.status.success());
    let printed = String::from_utf8(output.stdout).unwrap();
    let page = include_str!("../../../docs/scan.md");
    let shown = page.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    assert_eq!(lines(shown), lines(&printed), "docs/scan.md shows another output");
}
