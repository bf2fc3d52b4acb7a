//! Runs the program of the paper's authors as the profile `authors-code`, then repairs its slips one after
//! the other, down to the paper's formulas.
//!
//!     cargo run --release -p nextview-benchmarks --bin authors_code -- AUTHORS_FOLDER OUT
//!
//! The folder holds the authors' recorded Armadillo run. The folder OUT gets `scans.csv`, `first-plan.csv`
//! and `coverage.csv`, the same bits every time (docs/tables.md explains the columns); stdout gets the mean
//! planning time of every kind of run. With QUICK set, two runs of each kind are averaged.

use nextview_benchmarks::authors::recording::RecordedRun;
use nextview_benchmarks::authors::report::{Effort, Measurements};
use nextview_benchmarks::authors::run::ScannedObject;
use nextview_benchmarks::is_quick;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [folder, out] = &paths[..] else {
        let n = paths.len();
        return Err(format!("{n} arguments, expected the authors' folder and the folder to write").into());
    };
    let effort = match is_quick() {
        true => Effort { n_orders: 2, n_random: 2 },
        false => Effort { n_orders: 40, n_random: 200 },
    };
    let scene = ScannedObject::new(RecordedRun::read(folder)?)?;
    let report = Measurements::new(&scene, effort, |what| eprintln!("{what} ..."))?;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let tables = [report.scans, report.first_plan, report.coverage];
    for (name, table) in ["scans.csv", "first-plan.csv", "coverage.csv"].into_iter().zip(tables) {
        let path = out.join(name);
        std::fs::write(&path, table).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    print!("{}", report.times);
    Ok(())
}
