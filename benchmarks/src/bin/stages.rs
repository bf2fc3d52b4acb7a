//! Times the stages, with one line `nextview,STAGE,CASE,MILLISECONDS` each: the minimum of several runs.
//!
//!     cargo run --release -p nextview-benchmarks --bin stages -- cpu|wall FOLDER [FILTER]
//!
//! `cpu` is the CPU time of one thread, for comparison with single-threaded peers; `wall` is the elapsed time
//! with all threads (lines start with `nextview wall`). FOLDER holds a workload; FILTER is part of the names
//! of the stages to run. With the variable QUICK, each runs once.

use cpu_time::ProcessTime;
use nextview_benchmarks::is_quick;
use nextview_benchmarks::stage::{TimedWork, stages};
use nextview_benchmarks::workload::Workload;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// Minimum number of runs of a stage, and minimum total time.
const MIN_RUNS: usize = 3;
const MIN_SECONDS: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "usage: stages cpu|wall FOLDER [FILTER]";
    let mut args = std::env::args().skip(1);
    let (clock, label): (fn(&mut TimedWork<'_>) -> f64, _) = match args.next().as_deref() {
        Some("cpu") => (cpu_seconds, "nextview"),
        Some("wall") => (wall_seconds, "nextview wall"),
        _ => return Err(usage.into()),
    };
    if label == "nextview" {
        rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    }
    let workload = Workload::read(Path::new(&args.next().ok_or(usage)?))?;
    let filter = args.next().unwrap_or_default();
    let (min_runs, min_seconds) = if is_quick() { (1, 0.0) } else { (MIN_RUNS, MIN_SECONDS) };
    for stage in stages().iter().filter(|stage| stage.to_string().contains(&filter)) {
        let mut work = stage.prepare(&workload);
        let (start, mut n_runs, mut least) = (Instant::now(), 0, f64::INFINITY);
        while n_runs < min_runs || start.elapsed().as_secs_f64() < min_seconds {
            least = clock(&mut work).min(least);
            n_runs += 1;
        }
        println!("{label},{},{},{:.4}", stage.name, stage.case, 1e3 * least / stage.n_units as f64);
    }
    Ok(())
}

fn cpu_seconds(work: &mut TimedWork<'_>) -> f64 {
    let start = ProcessTime::now();
    work();
    start.elapsed().as_secs_f64()
}

fn wall_seconds(work: &mut TimedWork<'_>) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
