use crate::common::{Folder, small, timeless};
use serde_json::Value;

#[test]
fn equal_scans_give_equal_bytes_for_any_number_of_threads() {
    check_threads("determinism", &[]);
}

#[test]
fn noise_is_the_same_for_any_number_of_threads() {
    check_threads("noise", &["--noise", "d435i", "--pose-error-mm", "2", "--pose-error-deg", "0.2"]);
}

fn check_threads(name: &str, options: &[&str]) {
    let folder = Folder::new(name);
    let scan = |threads: &str| {
        let args = [options, &["--views", "3", "--json", "--threads", threads]].concat();
        let json = folder.json(&small(&args));
        let files = ["config.toml", "map.ot", "map.bt", "cloud.ply", "mesh.ply", "views.csv"];
        let files = files.map(|file| (file, folder.bytes(&format!("out/{file}"))));
        let steps = folder.text("out/steps.jsonl");
        let steps: Vec<Value> =
            steps.lines().map(|line| timeless(serde_json::from_str(line).unwrap())).collect();
        (timeless(json).to_string(), files, steps, without_measurements(&folder.text("out/report.html")))
    };
    let first = scan("1");
    for threads in ["1", "2", "4"] {
        let (json, files, steps, report) = scan(threads);
        assert_eq!(json, first.0, "{threads} threads");
        for (file, first) in files.iter().zip(&first.1) {
            assert!(file == first, "{} differs with {threads} threads", file.0);
        }
        assert_eq!(steps, first.2, "{threads} threads");
        assert!(report == first.3, "the report differs with {threads} threads");
    }
}

/// A page without times and memory: the number before each `ms`, `s` and `MB`.
fn without_measurements(page: &str) -> String {
    let is_border = |c: char| c.is_whitespace() || "<>".contains(c);
    let mut words: Vec<&str> = page.split_inclusive(is_border).collect();
    for i in 1..words.len() {
        let unit = words[i].trim_end_matches(|c| is_border(c) || c == ',');
        if ["ms", "s", "MB"].contains(&unit) {
            words[i - 1] = "";
        }
    }
    words.concat()
}

#[test]
fn a_seed_decides_the_candidates() {
    let folder = Folder::new("seeds");
    let scan = |seed: &str| {
        folder.ok(&small(&["--views", "1", "--baselines", "off", "--json", "--seed", seed]));
        folder.bytes("out/views.csv")
    };
    assert_ne!(scan("1"), scan("2"));
}
