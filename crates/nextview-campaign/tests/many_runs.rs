//! The memory per run of a large campaign, and the parts of its tables.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "../examples/many_runs/shards.rs"]
mod shards;

use nextview_campaign::statistics::{StudyBuilder, compare};
use nextview_campaign::store;
use nextview_scan::memory;
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name of the test, which calls itself in separate processes, and the variables that tell them what to do,
/// and where.
const TEST: &str = "little_is_held_of_each_run_and_tables_have_parts";
const WORK: &str = "NEXTVIEW_MANY_RUNS";

fn do_work(work: &str, dir: &Path) {
    let whole = dir.join("whole");
    let read = || store::read(&whole).unwrap();
    match work {
        "merge" => {
            let shards: Vec<PathBuf> = (1..=4).map(|n| dir.join("shards").join(n.to_string())).collect();
            store::merge(&shards, &whole).unwrap();
        }
        "compare" => assert!(compare(&read(), &read()).unwrap().is_identical()),
        _ => {
            let mut study = StudyBuilder::default();
            read().runs.iter().for_each(|run| study.add(&run.unwrap()));
            assert_eq!(study.build().objects.len(), 20);
        }
    }
    println!("peak {}", memory::peak_mb().unwrap_or_default());
}

/// Peak memory in kB of a separate process that does this work.
fn peak_kb(work: &str, dir: &Path) -> f64 {
    let mut command = Command::new(env::current_exe().unwrap());
    command.args(["--exact", TEST, "--nocapture"]).env(WORK, work).current_dir(dir);
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}");
    let (_, peak) = text.split_once("peak ").unwrap();
    1e3 * peak.lines().next().unwrap().parse::<f64>().unwrap()
}

/// Each part of a table has 2048 runs, and states their objects.
#[cfg(feature = "parquet")]
fn check_parts(dir: &Path, n_runs: usize) {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    for (table, n_rows) in [("runs", n_runs), ("steps", 10 * n_runs), ("times", 10 * n_runs)] {
        let file = std::fs::File::open(dir.join(format!("{table}.parquet"))).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let groups = reader.metadata().row_groups();
        let sizes: Vec<i64> = groups.iter().map(|group| group.num_rows()).collect();
        let part = 2048 * n_rows / n_runs;
        let expected = (0..n_rows).step_by(part).map(|first| part.min(n_rows - first) as i64);
        assert_eq!(sizes, expected.collect::<Vec<_>>(), "{table}");
        for group in groups {
            let objects = group.column(0).statistics().unwrap();
            let [least, greatest] =
                [objects.min_bytes_opt(), objects.max_bytes_opt()].map(|name| name.unwrap());
            assert!(least.starts_with(b"random-") && least < greatest, "{table}");
        }
    }
}

/// A record has 18 kB of text, and more in memory. Far less is held for each run: its place in the file, for
/// a comparison six numbers, and for a report the numbers of its views.
#[test]
fn little_is_held_of_each_run_and_tables_have_parts() {
    if let Ok(work) = env::var(WORK) {
        return do_work(&work, Path::new(""));
    }
    let folder = env::temp_dir().join(format!("nextview-many-runs-{}", std::process::id()));
    // Both have one complete part of each table, whose records are held together.
    let (few, many) = (21, 60);
    let peaks = [few, many].map(|n_seeds| {
        let dir = folder.join(n_seeds.to_string());
        shards::write(&dir.join("shards"), [20, n_seeds, 4], 0).unwrap();
        ["merge", "compare", "report"].map(|work| peak_kb(work, &dir))
    });
    #[cfg(feature = "parquet")]
    check_parts(&folder.join(many.to_string()).join("whole"), 100 * many);
    std::fs::remove_dir_all(&folder).unwrap();
    let n_more = (100 * (many - few)) as f64;
    for (i, (work, bound_kb)) in [("merge", 3.0), ("compare", 4.0), ("report", 5.0)].into_iter().enumerate() {
        let per_run_kb = (peaks[1][i] - peaks[0][i]) / n_more;
        println!("{work}: {per_run_kb:.1} kB for each run more");
        assert!(per_run_kb < bound_kb, "{work}: {per_run_kb} kB for each run more");
    }
}
