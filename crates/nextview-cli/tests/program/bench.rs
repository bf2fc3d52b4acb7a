//! Campaigns: the tables are the same whatever happens during execution.

use crate::common::Folder;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::fs::File;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Coarse voxels and a small camera: takes about a second.
const SPEC: &str = r#"
name = "tiny"
objects = ["builtin:mug", "builtin:bracket"]
[scan]
profile = "paper"
candidates = 20
views = 3
voxel_size_m = 0.02
stop.entropy_share = 0
camera = { width = 80, height = 60, fx = 76, fy = 76, cx = 40, cy = 30 }
[[variant]]
scan.planner = "random"
seeds = [0, 1]
[[variant]]
label = "flow, \"gamma\" {max_flow.gamma}"
sweep."max_flow.gamma" = [0, 0.5]
[[variant]]
scan = { planner = "clairvoyant", baselines = false }
"#;

const N_RUNS: usize = 10;

/// The tables that must not depend on how the campaign was executed.
const TABLES: [&str; 4] = ["runs.csv", "runs.parquet", "steps.csv", "steps.parquet"];

const FILES: [&str; 8] = [
    "runs.csv",
    "runs.jsonl",
    "runs.parquet",
    "spec.toml",
    "steps.csv",
    "steps.parquet",
    "times.csv",
    "times.parquet",
];

/// A folder with the finished campaign in `bench-tiny`, which all others must equal.
fn finished(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("tiny.toml", SPEC);
    folder.ok(&["bench", "tiny.toml"]);
    folder
}

fn check_tables(folder: &Folder, out: &str) {
    for table in TABLES {
        let [expected, found] = ["bench-tiny", out].map(|dir| folder.bytes(&format!("{dir}/{table}")));
        assert!(expected == found, "{table} differs in {out}");
    }
    assert_eq!(folder.names(out), FILES);
}

/// The lines of a table of Parquet as CSV.
fn as_csv(path: &Path) -> String {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let line = |fields: Vec<String>| fields.join(",") + "\n";
    let fields = reader.metadata().file_metadata().schema().get_fields().to_vec();
    let head = line(fields.iter().map(|field| field.name().to_owned()).collect());
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        line(row.get_column_iter().map(|(_, field)| text(field)).collect())
    });
    head + &rows.collect::<String>()
}

fn text(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Bool(value) => value.to_string(),
        Field::Long(value) => value.to_string(),
        Field::Double(value) => value.to_string(),
        Field::Str(text) if text.contains([',', '"']) => format!("\"{}\"", text.replace('"', "\"\"")),
        Field::Str(text) => text.clone(),
        field => panic!("an unexpected type: {field:?}"),
    }
}

#[test]
fn tables_do_not_depend_on_the_number_of_jobs() {
    let folder = finished("bench-jobs");
    for jobs in ["1", "2", "5"] {
        folder.ok(&["bench", "tiny.toml", "--jobs", jobs, "--out", jobs]);
        check_tables(&folder, jobs);
    }
    let has_memory = |out: &str| {
        let times = folder.text(&format!("{out}/times.csv"));
        times.lines().skip(1).all(|line| !line.contains(",,"))
    };
    assert!(!has_memory("2"), "memory is that of a run only where there is no other beside it");
    assert!(!cfg!(target_os = "linux") || has_memory("1"));
}

#[test]
fn tables_hold_every_run_and_view() {
    let folder = finished("bench-tables");
    for table in ["runs", "steps", "times"] {
        let path = format!("bench-tiny/{table}");
        let csv = folder.text(&format!("{path}.csv"));
        assert_eq!(as_csv(&folder.path(&format!("{path}.parquet"))), csv);
        assert!(csv.contains("\nmug,builtin,\"flow, \"\"gamma\"\" 0.5\",0,0,"), "{csv}");
    }
    let runs = folder.text("bench-tiny/runs.csv");
    assert_eq!(runs.lines().count(), 1 + N_RUNS);
    assert!(runs.starts_with(
        "object,data_set,variant,seed,view_seed,first_view,config.baseline_seed,config.baselines,"
    ));
    for column in ["cloud_accuracy_mean_mm", "cloud_completeness_2mm"] {
        let at = runs.lines().next().unwrap().split(',').position(|name| name == column).unwrap();
        let columns_after = runs.lines().next().unwrap().split(',').count() - at;
        // Counted from the end, since labels contain commas.
        let values = runs.lines().skip(1).map(|line| line.rsplit(',').nth(columns_after - 1).unwrap());
        let values: Vec<f64> = values.map(|value| value.parse().unwrap()).collect();
        assert!(values.iter().all(|value| (1e-6..2.0).contains(value)), "{column}: {values:?}");
    }
    assert_eq!(folder.text("bench-tiny/runs.jsonl").lines().count(), N_RUNS);
    assert_eq!(folder.names("bench-tiny"), FILES);
}

#[test]
fn a_killed_campaign_goes_on_to_the_same_tables() {
    let folder = finished("bench-kill");
    for (n_lines, jobs) in [(0, "2"), (1, "1"), (4, "2"), (7, "1"), (N_RUNS, "2")] {
        let out = format!("after-{n_lines}");
        let args = ["bench", "tiny.toml", "--jobs", jobs, "--out", &out, "--resume"];
        let mut child = folder.command(&args).stdout(Stdio::null()).spawn().unwrap();
        let runs = folder.path(&format!("{out}/runs.jsonl"));
        let n_done = || std::fs::read(&runs).ok().map(|text| text.iter().filter(|b| **b == b'\n').count());
        let start = Instant::now();
        while n_done().is_none_or(|n| n < n_lines) && child.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < Duration::from_secs(60), "{n_lines} runs take forever");
        }
        child.kill().unwrap();
        child.wait().unwrap();
        // The specification is left out if the folder holds it.
        let has_spec = folder.path(&format!("{out}/spec.toml")).exists();
        let spec: &[&str] = if has_spec { &[] } else { &["tiny.toml"] };
        folder.ok(&[&["bench", "--resume", "--out", &out], spec].concat());
        check_tables_but_leftovers(&folder, &out);
    }
}

/// A killed process may leave a table that it was about to publish.
fn check_tables_but_leftovers(folder: &Folder, out: &str) {
    for name in folder.names(out).iter().filter(|name| name.ends_with(".partial")) {
        std::fs::remove_file(folder.path(&format!("{out}/{name}"))).unwrap();
    }
    check_tables(folder, out);
}

#[test]
fn a_torn_last_line_is_done_again_and_other_damage_is_reported() {
    let folder = finished("bench-torn");
    std::fs::create_dir(folder.path("torn")).unwrap();
    let spec = folder.bytes("bench-tiny/spec.toml");
    let runs = folder.text("bench-tiny/runs.jsonl");
    let resume = ["bench", "--resume", "--out", "torn"];
    let put = |text: &str| {
        folder.write("torn/spec.toml", &spec);
        folder.write("torn/runs.jsonl", text);
    };
    let end_of_last = runs.len() - 1;
    for cut in [end_of_last, end_of_last - 40] {
        put(&runs[..cut]);
        let run = folder.run(&resume);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert_eq!(run.stderr, "note: the last line of runs.jsonl is incomplete; its run is repeated\n");
        assert!(run.stdout.contains("10 runs, 9 already done"), "{}", run.stdout);
        check_tables(&folder, "torn");
    }
    let mut lines: Vec<&str> = runs.lines().collect();
    put(&([&lines[..], &lines[..1]].concat().join("\n") + "\n"));
    assert_eq!(folder.run(&resume).code, Some(0), "equal records of one run are one");
    let refused = |lines: &[&str], part: &str| {
        put(&(lines.join("\n") + "\n"));
        let run = folder.run(&resume);
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.contains("runs.jsonl") && run.stderr.contains(part), "{}", run.stderr);
    };
    refused(&[lines[0], "{", lines[1]], "line 2, column ");
    let other = lines[0].replace("\"false_voxels\":", "\"false_voxels\":9");
    refused(&[lines[0], lines[1], &other], "lines 1 and 3 have different records of the same run");
    let other = lines[2].replace("\"views\":3", "\"views\":4");
    refused(&[lines[0], &other, lines[1]], "views is 4 there, 3 here");
    let other = lines[2].replace("\"seed\":", "\"seed\":9");
    lines[2] = &other;
    refused(&lines, "no run of this campaign");
}

/// The cells of a line of CSV; commas in quotes are part of a cell.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    for c in line.chars() {
        match c {
            '"' => is_quoted ^= true,
            ',' if !is_quoted => cells.push(String::new()),
            c => cells.last_mut().unwrap().push(c),
        }
    }
    cells
}

/// A row of a campaign's table: returns the value of a column.
fn row(folder: &Folder, number: usize) -> impl Fn(&str) -> String {
    let csv = folder.text("bench-tiny/runs.csv");
    let mut lines = csv.lines();
    let [names, values] = [lines.next().unwrap(), lines.nth(number - 1).unwrap()].map(cells);
    assert_eq!(names.len(), values.len());
    move |name| values[names.iter().position(|known| known == name).unwrap()].clone()
}

#[test]
fn a_run_of_a_campaign_is_repeated_by_a_scan() {
    let folder = Folder::new("bench-again");
    let noise = "[scan]\nnoise = { model = \"d435i\", pose_error_mm = 3 }\n";
    folder.write("tiny.toml", SPEC.replace("[scan]\n", noise).replace("name =", "first_views = 2\nname ="));
    let said = folder.ok(&["bench", "tiny.toml"]);
    assert!(said.contains("nextview bench --out bench-tiny --config-of ROW > run.toml"), "{said}");
    // Random views, first of seed 0 and then of seed 1, from two first views each.
    let mut skills = Vec::new();
    for number in 1..=4 {
        let row = row(&folder, number);
        let config = folder.ok(&["bench", "--out", "bench-tiny", "--config-of", &number.to_string()]);
        folder.write("run.toml", &config);
        let out = format!("again-{number}");
        let scan = folder.json(&["scan", "--config", "run.toml", "--json", "--out", &out]);
        for name in ["skill", "reachable_coverage", "path_length_m", "cloud_accuracy_mean_mm"] {
            assert_eq!(scan[name].to_string(), row(name), "{name} in row {number}");
        }
        for (name, column) in [
            ("seed", "config.seed"),
            ("view_seed", "config.view_seed"),
            ("noise_seed", "config.noise.seed"),
            ("baseline_seed", "config.baseline_seed"),
        ] {
            assert_eq!(scan[name].to_string(), row(column), "{name}");
        }
        skills.push(row("skill"));
    }
    skills.sort();
    skills.dedup();
    assert_eq!(skills.len(), 4);
    for (row, part) in [("0", "there is no row 0"), ("99", "there is no row 99, expected 1 to 20")] {
        let run = folder.run(&["bench", "--out", "bench-tiny", "--config-of", row]);
        assert!(run.code == Some(2) && run.stderr.contains(part), "{}", run.stderr);
    }
}

#[test]
fn random_objects_are_built_in_objects() {
    let folder = Folder::new("bench-random-objects");
    folder.write("tiny.toml", SPEC.replace("builtin:mug", "builtin:random-3"));
    folder.ok(&["bench", "tiny.toml", "builtin:random-17", "--out", "other"]);
    let runs = folder.text("other/runs.csv");
    assert_eq!(runs.matches("\nrandom-17,builtin,").count(), N_RUNS / 2, "{runs}");
    folder.ok(&["bench", "tiny.toml"]);
    assert_eq!(folder.text("bench-tiny/runs.csv").matches("\nrandom-3,builtin,").count(), N_RUNS / 2);
}

#[test]
fn a_broken_object_does_not_stop_the_others() {
    let folder = Folder::new("bench-broken");
    let objects =
        "objects = [\"builtin:mug\", \"broken.ply\", { file = \"m.obj\", unit = \"m\", size_m = 9 }]";
    folder.write("tiny.toml", SPEC.replace("objects = [\"builtin:mug\", \"builtin:bracket\"]", objects));
    folder.write("broken.ply", "ply\n");
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for args in [&["bench", "tiny.toml"][..], &["bench", "tiny.toml", "--resume"]] {
        let run = folder.run(args);
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.starts_with("error: 10 of 15 runs failed\n  broken (5 runs): "), "{}", run.stderr);
        assert!(run.stderr.contains("\n  m (5 runs): ") && run.stderr.contains("9 m"), "{}", run.stderr);
    }
    let runs = folder.text("bench-tiny/runs.csv");
    assert_eq!((runs.matches(",done,").count(), runs.matches(",failed,").count()), (5, 10), "{runs}");
    assert_eq!(folder.text("bench-tiny/steps.csv").lines().count(), 1 + 5 * 3);
}

#[test]
fn a_folder_is_that_of_one_campaign() {
    let folder = finished("bench-folder");
    let refused = |args: &[&str], parts: &[&str]| {
        let run = folder.run(args);
        assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""), "{}", run.stderr);
        for part in [&["bench-tiny", "hint: "], parts].concat() {
            assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr);
        }
    };
    let again = ["bench", "tiny.toml", "--out", "bench-tiny"];
    refused(&again, &["already has the results of a campaign", "--resume"]);
    folder.write("other.toml", SPEC.replace("views = 3", "views = 4"));
    refused(&["bench", "other.toml", "--resume"], &["spec.toml: ", "scan.views is 3 there, 4 here"]);
    let runs = File::options().append(true).open(folder.path("bench-tiny/runs.jsonl")).unwrap();
    runs.lock().unwrap();
    refused(&["bench", "tiny.toml", "--resume"], &["another process is writing there"]);
    drop(runs);
    folder.ok(&["bench", "tiny.toml", "--resume"]);
}

#[test]
fn a_finished_campaign_is_not_that_of_the_next() {
    let folder = finished("bench-next");
    let first = folder.bytes("bench-tiny/runs.jsonl");
    let told = folder.ok(&["bench", "tiny.toml"]);
    assert!(told.contains("results in bench-tiny-2 ("), "{told}");
    check_tables(&folder, "bench-tiny-2");
    assert_eq!(folder.bytes("bench-tiny/runs.jsonl"), first);
    // The last campaign is resumed, or an interrupted one after it.
    let resumed = folder.ok(&["bench", "tiny.toml", "--resume"]);
    assert!(resumed.contains("10 runs, 10 already done, in bench-tiny-2\n"), "{resumed}");
    let lines = folder.text("bench-tiny/runs.jsonl");
    folder.write("bench-tiny-3/runs.jsonl", lines.lines().next().unwrap().to_owned() + "\n");
    folder.write("bench-tiny-3/spec.toml", folder.bytes("bench-tiny/spec.toml"));
    let run = folder.run(&["bench", "tiny.toml"]);
    assert!(
        run.code == Some(1) && run.stderr.contains("bench-tiny-3: already has the results of"),
        "{}",
        run.stderr
    );
    let resumed = folder.ok(&["bench", "tiny.toml", "--resume"]);
    assert!(resumed.contains("10 runs, 1 already done, in bench-tiny-3\n"), "{resumed}");
}

#[test]
fn other_files_are_neither_specification_nor_tables() {
    let folder = Folder::new("bench-others");
    // The specification that the campaign writes would contain the absolute path.
    let spec = SPEC.replace("builtin:mug", "part.obj");
    folder.write("spec.toml", &spec);
    folder.write("part.obj", "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nf 1 2 3\n");
    let refused = |name: &str, part: &str| {
        let run = folder.run(&["bench", "spec.toml", "--out", "."]);
        assert!(run.code == Some(1) && run.stderr.contains(part), "{name}: {}", run.stderr);
        assert!(run.stderr.contains("choose another folder (--out)") && !run.stderr.contains("--force"));
        assert!(!folder.path("runs.jsonl").exists());
    };
    refused("specification", "spec.toml: the folder belongs to another specification");
    assert_eq!(folder.text("spec.toml"), spec);
    folder.write("steps.csv", "mine");
    refused("table", ".: already holds results: steps.csv");
    assert_eq!(folder.text("steps.csv"), "mine");
}

#[test]
fn objects_on_the_command_line_replace_those_of_the_specification() {
    let folder = Folder::new("bench-objects");
    folder.write("tiny.toml", SPEC.replace("objects = [", "objects = [\"none/*.ply\", "));
    std::fs::create_dir(folder.path("set")).unwrap();
    folder.write("set/b.obj", "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nf 1 2 3\n");
    folder.write("set/a.obj", "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0.1\nf 1 2 3\n");
    let text = folder.ok(&["bench", "tiny.toml", "set/*.obj", "--jobs", "1"]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[..3], ["tiny: 2 objects, 10 runs, in bench-tiny", "a: 5 runs", "b: 5 runs"]);
    assert!(lines[4].starts_with("10 runs, ") && lines[4].contains("results in bench-tiny"), "{text}");
    assert!(folder.text("bench-tiny/runs.csv").contains("\na,set,random,0,0,"));
}

#[test]
fn lists_what_is_built_in() {
    let list = Folder::new("bench-list").ok(&["bench", "--list"]);
    assert!(list.starts_with("paper-1  table I") && list.lines().count() >= 5, "{list}");
}
