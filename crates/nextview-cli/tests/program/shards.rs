//! Campaigns in shards: the tables are the same, no matter which process executes the runs or is killed.

use crate::common::{Folder, Run};
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Coarse voxels and a small camera; 24 runs on three objects.
const SPEC: &str = r#"
name = "tiny"
objects = ["builtin:mug", "builtin:bracket", "builtin:random-7"]
seeds = [0, 1]
first_views = [0, 5]
[scan]
profile = "paper"
candidates = 20
views = 3
voxel_size_m = 0.02
stop.entropy_share = 0
camera = { width = 80, height = 60, fx = 76, fy = 76, cx = 40, cy = 30 }
[[variant]]
scan.planner = "random"
[[variant]]
scan.planner = "max-flow"
"#;

/// The files that must not depend on which process executed the runs.
const TABLES: [&str; 5] = ["runs.csv", "runs.parquet", "spec.toml", "steps.csv", "steps.parquet"];

fn new(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("tiny.toml", SPEC);
    folder
}

fn shard(folder: &Folder, shard: &str, out: &str) -> String {
    folder.ok(&["bench", "tiny.toml", "--shard", shard, "--out", out, "--resume"])
}

/// The folders of four shards.
fn sharded(name: &str) -> Folder {
    let folder = new(name);
    for number in 1..=4 {
        shard(&folder, &format!("{number}/4"), &format!("shard-{number}"));
    }
    folder
}

fn check_tables(folder: &Folder, out: &str) {
    for table in TABLES {
        let [expected, found] = ["bench-tiny", out].map(|dir| folder.bytes(&format!("{dir}/{table}")));
        assert!(expected == found, "{table} differs in {out}");
    }
}

#[test]
fn shards_in_any_order_killed_and_repeated_give_the_tables_of_one_process() {
    let folder = new("shards");
    folder.ok(&["bench", "tiny.toml"]);
    let said = shard(&folder, "4/5", "d");
    assert!(said.contains("tiny: 2 objects, 5 runs, in d\n") && said.contains("shard 4/5 in d;"), "{said}");
    assert_eq!(folder.names("d"), ["runs.jsonl", "spec.toml"]);
    // The shard is killed after its first runs, and resumed.
    let args = ["bench", "tiny.toml", "--shard", "2/5", "--jobs", "1", "--out", "b", "--resume"];
    let mut child = folder.command(&args).stdout(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    while fs::read(folder.path("b/runs.jsonl")).is_ok_and(|text| text.is_empty())
        && child.try_wait().unwrap().is_none()
    {
        assert!(start.elapsed() < Duration::from_secs(60), "a run takes forever");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    for (number, out) in [("5/5", "e"), ("1/5", "a"), ("2/5", "b"), ("3/5", "c"), ("3/5", "c-again")] {
        shard(&folder, number, out);
    }
    let before: Vec<Vec<u8>> = ["a", "b"].map(|dir| folder.bytes(&format!("{dir}/runs.jsonl"))).into();
    let said = folder.ok(&["merge", "c", "a", "e", "c-again", "b", "d", "--out", "whole"]);
    assert_eq!(said, "24 runs of 6 folders, 5 identical duplicates; results in whole\n");
    check_tables(&folder, "whole");
    let after: Vec<Vec<u8>> = ["a", "b"].map(|dir| folder.bytes(&format!("{dir}/runs.jsonl"))).into();
    assert!(before == after, "the shards stay as they are");
    // The merged folder is a campaign like any other.
    let said = folder.ok(&["bench", "--resume", "--out", "whole"]);
    assert!(said.contains("24 runs, 24 already done"), "{said}");
    assert!(folder.ok(&["compare", "bench-tiny", "whole"]).contains("identical apart from times"));
    folder.ok(&["report", "whole"]);
}

#[test]
fn more_shards_than_runs_are_fine_and_have_folders_of_their_own() {
    let folder = new("shards-many");
    folder.write("tiny.toml", SPEC.replace("seeds = [0, 1]\nfirst_views = [0, 5]\n", ""));
    folder.ok(&["bench", "tiny.toml"]);
    for number in 1..=8 {
        folder.ok(&["bench", "tiny.toml", "--shard", &format!("{number}/8")]);
    }
    let dirs: Vec<String> = (1..=8).map(|number| format!("bench-tiny-{number}-of-8")).collect();
    let dirs: Vec<&str> = dirs.iter().map(String::as_str).collect();
    folder.ok(&[&["merge"], &dirs[..], &["--out", "new/whole"]].concat());
    check_tables(&folder, "new/whole");
    assert_eq!(folder.names("new"), ["whole/"]);
}

fn refused(folder: &Folder, dirs: &[&str], out: &str, parts: &[&str]) -> Run {
    let run = folder.run(&[&["merge"], dirs, &["--out", out]].concat());
    assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""), "{}", run.stderr);
    for part in parts {
        assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr);
    }
    run
}

#[test]
fn all_that_is_wrong_is_told_and_nothing_is_written() {
    let folder = sharded("shards-wrong");
    let lines = folder.text("shard-1/runs.jsonl");
    let first = lines.lines().next().unwrap();
    let put = |dir: &str, text: &str| {
        folder.write(&format!("{dir}/spec.toml"), folder.bytes("shard-1/spec.toml"));
        folder.write(&format!("{dir}/runs.jsonl"), text);
    };
    let source = first.split("\"source\":\"").nth(1).unwrap().split('"').next().unwrap();
    put("other-build", &lines.replace(source, "feedfeedfeed"));
    put("other-result", &(first.replace("\"false_voxels\":", "\"false_voxels\":9") + "\n"));
    put("no-record", &format!("{{\n{first}\n"));
    put("stranger", &(first.replacen("\"seed\":0", "\"seed\":77", 1) + "\n"));
    folder.write("other-spec/spec.toml", folder.text("shard-1/spec.toml").replace("views = 3", "views = 4"));
    folder.write("other-spec/runs.jsonl", "");
    folder.write("empty/x", "");
    let names = folder.names(".");
    let dirs = [
        "shard-1",
        "shard-2",
        "shard-4",
        "other-build",
        "other-result",
        "no-record",
        "stranger",
        "other-spec",
        "empty",
    ];
    let version = format!("0.1.0 ({source})");
    let parts = [
        "6 of 24 runs are missing:\n  object ",
        &format!("6 runs were computed by build 0.1.0 (feedfeedfeed), but this is build {version}"),
        "other-result/runs.jsonl, line 1, column 1: line 1 of shard-1/runs.jsonl and line 1 have different",
        "no-record/runs.jsonl, line 1, column ",
        "stranger/runs.jsonl, line 1, column 1: no run of this campaign: object ",
        "other-spec/spec.toml: the folder belongs to another specification: scan.views is 3 there, 4 here",
        "empty/spec.toml: cannot be read",
    ];
    let run = refused(&folder, &dirs, "whole", &parts);
    assert_eq!(run.stderr.matches("error: ").count(), parts.len(), "{}", run.stderr);
    assert_eq!(folder.names("."), names, "nothing is left");
}

#[test]
fn a_merge_replaces_nothing_and_leaves_out_torn_lines() {
    let folder = sharded("shards-out");
    let all = ["shard-1", "shard-2", "shard-3", "shard-4"];
    folder.write("mine/x", "");
    for out in ["mine", "tiny.toml"] {
        refused(&folder, &all, out, &["is not empty, and existing files are not replaced", "(--out)"]);
    }
    refused(&folder, &all, "shard-2", &["shard-2: is inside shard-2, which is an input", "(--out)"]);
    for out in ["shard-2/whole", "mine/../shard-2/new/whole"] {
        refused(&folder, &all, out, &["whole: is inside shard-2, which is an input", "(--out)"]);
    }
    refused(
        &folder,
        &["tiny.toml"],
        "whole",
        &["tiny.toml/spec.toml: cannot be read", "expected the folder of"],
    );
    let lines = folder.text("shard-3/runs.jsonl");
    folder.write("shard-3/runs.jsonl", &lines[..lines.len() - 9]);
    refused(&folder, &all, "whole", &["1 of 24 runs are missing:\n  object ", "--resume"]);
    // If it is complete in another folder, it is not missing.
    folder.write("again/runs.jsonl", &lines);
    folder.write("again/spec.toml", folder.bytes("shard-1/spec.toml"));
    let run = folder.run(&[&["merge", "again"], &all[..], &["--out", "whole"]].concat());
    assert_eq!(run.stderr, "note: the last line of shard-3/runs.jsonl is incomplete and was left out\n");
    assert!(run.code == Some(0) && run.stdout.contains("5 identical duplicates"), "{}", run.stdout);
}

#[test]
fn failed_runs_are_results_of_a_shard_and_of_the_whole() {
    let folder = new("shards-failed");
    folder.write("tiny.toml", SPEC.replace("builtin:bracket", "broken.ply"));
    folder.write("broken.ply", "ply\n");
    for number in 1..=3 {
        let run = folder.run(&["bench", "tiny.toml", "--shard", &format!("{number}/3")]);
        assert_eq!(run.code, Some(if number == 2 { 1 } else { 0 }), "{}", run.stderr);
    }
    let dirs = ["bench-tiny-1-of-3", "bench-tiny-2-of-3", "bench-tiny-3-of-3"];
    let run = folder.run(&[&["merge"], &dirs[..], &["--out", "whole"]].concat());
    assert!(run.code == Some(1) && run.stderr.starts_with("error: 8 of 24 runs failed\n  broken (8 runs): "));
    assert!(folder.text("whole/runs.csv").contains(",failed,"));
}

#[test]
fn a_shard_is_a_number_of_all() {
    let folder = new("shards-number");
    for shard in ["0/4", "5/4", "four", "1/0"] {
        let run = folder.run(&["bench", "tiny.toml", "--shard", shard]);
        assert!(run.code == Some(2) && run.stderr.contains("such as 3/64"), "{}", run.stderr);
    }
    assert_eq!(folder.names("."), ["tiny.toml"]);
}

/// A limit on the size of files simulates a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_no_run_that_was_kept() {
    let folder = new("shards-full");
    folder.ok(&["bench", "tiny.toml"]);
    let limited = |kib: u64, args: &str| {
        let program = env!("CARGO_BIN_EXE_nextview");
        let script = format!("trap '' XFSZ; ulimit -f {kib}; exec {program} {args}");
        let mut command = Command::new("bash");
        command.args(["-c", &script]).current_dir(folder.path(".")).stdin(Stdio::null());
        Run::of(command)
    };
    let run = limited(40, "bench tiny.toml --out small --jobs 1");
    assert_eq!(run.code, Some(1));
    let expected = "error: small/runs.jsonl: cannot be written: File too large";
    assert!(
        run.stderr.contains(expected) && run.stderr.contains("hint: resume the campaign once"),
        "{}",
        run.stderr
    );
    let n_kept = folder.text("small/runs.jsonl").matches('\n').count();
    assert!((1..24).contains(&n_kept));
    let run = folder.run(&["bench", "--resume", "--out", "small"]);
    assert!(
        run.code == Some(0) && run.stdout.contains(&format!("24 runs, {n_kept} already done")),
        "{}",
        run.stdout
    );
    check_tables(&folder, "small");
    // The tables and a merge do not fit, either.
    fs::remove_file(folder.path("small/runs.csv")).unwrap();
    let run = limited(8, "bench --resume --out small");
    assert!(
        run.code == Some(1) && run.stderr.contains("small/runs.csv: cannot be written"),
        "{}",
        run.stderr
    );
    let run = limited(40, "merge small --out whole");
    assert!(run.code == Some(1) && run.stderr.contains("runs.jsonl: cannot be written"), "{}", run.stderr);
    assert_eq!(folder.names("."), ["bench-tiny/", "small/", "tiny.toml"]);
    folder.ok(&["bench", "--resume", "--out", "small"]);
    check_tables(&folder, "small");
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = new("shards-read-only");
    for args in [&["bench", "tiny.toml", "--shard", "1/24"][..], &["merge", "bench-tiny-1-of-24"]] {
        let run = folder.run(&[args, &["--out", "/proc/nextview/x"]].concat());
        assert!(
            run.code == Some(1) && run.stderr.contains("/proc/nextview/x: cannot be written: "),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn a_cache_of_truths_changes_no_table_whatever_is_in_it() {
    let folder = new("shards-truths");
    folder.ok(&["bench", "tiny.toml"]);
    let cached = |out: &str, more: &[&str]| {
        folder.ok(&[&["bench", "tiny.toml", "--out", out, "--truth-cache", "truths"], more].concat());
    };
    cached("cold", &[]);
    check_tables(&folder, "cold");
    let names = folder.names("truths");
    assert_eq!(names.len(), 3, "an entry for each object: {names:?}");
    // One entry is damaged, one belongs to another object, and one is missing.
    let entry = |i: usize| format!("truths/{}", names[i]);
    folder.write(&entry(0), &folder.bytes(&entry(0))[..99]);
    folder.write(&entry(1), folder.bytes(&entry(2)));
    fs::remove_file(folder.path(&entry(2))).unwrap();
    cached("1", &["--shard", "1/2"]);
    cached("2", &["--shard", "2/2"]);
    folder.ok(&["merge", "1", "2", "--out", "whole"]);
    check_tables(&folder, "whole");
    cached("small", &["--truth-cache-mb", "0"]);
    check_tables(&folder, "small");
    assert_eq!(folder.names("truths"), names);
    let run = folder.run(&["bench", "tiny.toml", "--out", "none", "--truth-cache", "tiny.toml/x"]);
    assert!(
        run.code == Some(1) && run.stderr.starts_with("error: tiny.toml/x: cannot be written: "),
        "{}",
        run.stderr
    );
    assert!(!folder.path("none").exists());
}
