use crate::bench::{self, Request};
use crate::{Failure, stdout};
use clap::Args;
use std::path::PathBuf;

/// Run a campaign: many scans of many objects by several planners, measured alike.
///
/// A specification names the objects, the planners with their parameters, the seeds and the first views; all combinations
/// are run. What fails is recorded and does not stop the rest. An interrupted campaign goes on with --resume; its
/// results are the same, for any number of jobs and threads.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct BenchArgs {
    /// A TOML file or a built-in specification (see --list)
    spec: Option<String>,
    /// Mesh files or builtin:NAME (see scan), in place of the objects of the specification
    mesh: Vec<String>,
    /// Folder for the results [default: bench-NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Runs beside each other [default: one per thread]; with 1, times and memory are undisturbed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Go on with the campaign in the folder; SPEC may be left out then
    #[arg(long)]
    resume: bool,
    /// Show the built-in specifications
    #[arg(long, conflicts_with_all = ["spec", "out", "jobs", "resume"])]
    list: bool,
}

const EXAMPLES: &str = "\
Examples:
  nextview bench paper-1                            the paper's table I, on the built-in objects
  nextview bench paper-1 meshes/*.ply --out mine    on your own
  nextview bench mine.toml --jobs 4                 your own specification
  nextview bench --resume --out mine                go on after an interruption

A specification (keys of `scan` as in config.toml; docs/bench.md tells all):
  name = \"mine\"
  objects = [\"meshes/*.ply\", \"builtin:mug\", { file = \"a.stl\", unit = \"mm\" }]
  [scan]
  profile = \"paper\"
  [[variant]]
  scan.planner = \"max-flow\"
  sweep.\"max_flow.gamma\" = [0, 0.5, 1]
  [[variant]]
  scan.planner = \"random\"
  seeds = [0, 1, 2]

The folder holds spec.toml, runs.jsonl (a line per run, as soon as it is done) and, at the end, the
tables runs (a row per run), steps (a row per view) and times, each as .csv and .parquet.";

impl BenchArgs {
    pub fn run(self) -> Result<(), Failure> {
        if self.list {
            return stdout::print(bench::list());
        }
        bench::bench(&Request {
            spec: self.spec,
            meshes: self.mesh,
            out: self.out,
            jobs: self.jobs.map(usize::from),
            resume: self.resume,
        })
    }
}
