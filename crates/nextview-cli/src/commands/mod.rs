//! The commands of the program.

mod batch;
mod bench;
mod campaign;
mod compare;
mod completions;
mod dataset;
mod export;
mod inspect;
mod man;
mod map;
mod merge;
mod plan;
mod report;
mod scan;
mod serve;
mod values;
mod version;
mod views;

use crate::Failure;
use clap::{CommandFactory, Parser, Subcommand};
use nextview_scan::process;

/// Decides where a depth camera should look next, so that an unknown object is scanned completely in as few
/// views as possible.
///
/// `nextview scan` scans a simulated object from the first view to the last and writes the map, the cloud,
/// the mesh and a report. `nextview bench` scans many objects with many planners, on one machine or in shards
/// on several; `nextview merge` combines the shards. `nextview report` and `nextview compare` make figures
/// and tables of the results. `nextview export` converts the results of a scan for other tools; `nextview
/// inspect` compares them with a CAD model. `nextview serve` receives the frames of any camera over HTTP and
/// returns the next view. `nextview plan` prints the next view, or the next few, for a saved map; `nextview
/// map` summarises and converts maps. `nextview views` makes view candidates, `nextview dataset` training
/// data for learned planners. `nextview completions` and `nextview man` write shell completions and manual
/// pages.
#[derive(Debug, Parser)]
#[command(name = "nextview", version, long_version = version::long(), max_term_width = 100, after_help = EXAMPLES)]
pub struct Cli {
    /// Number of threads [default: all cores], at most four for each core; results do not depend on it
    #[arg(long, global = true, display_order = 100, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  nextview scan                              scan a built-in teapot; then open its report.html
  nextview scan part.stl --unit mm           scan your own mesh
  nextview scan builtin:mug --planner local  another object, another planner
  nextview export scan-part --to bop --out part-bop
                                             export its results for another tool
  nextview bench paper-1 meshes/*.ply        every planner on your meshes
  nextview report bench-paper-1              its figures and tables
  nextview serve                             scan with any camera, over HTTP
  nextview map info map.ot                   summary of a map
  nextview views > views.csv                 poses to choose from
  nextview plan --map map.ot --views views.csv
  nextview dataset nbv-net --out nbv-data    training data for NBV-Net
  nextview completions bash                  shell completion for bash
  nextview man --out man1                    this help as manual pages

Conventions: metres, world frame right-handed with z up, camera frame x right, y down, z forward.
Data goes to stdout, messages to stderr.
Exit codes: 0 success, 1 bad data or a system failure, 2 bad usage, 130 interrupted.";

#[derive(Debug, Subcommand)]
enum Command {
    Scan(Box<scan::ScanArgs>),
    Export(export::ExportArgs),
    Inspect(inspect::InspectArgs),
    Bench(bench::BenchArgs),
    Merge(merge::MergeArgs),
    Report(report::ReportArgs),
    Compare(compare::CompareArgs),
    Serve(serve::ServeArgs),
    Plan(plan::PlanArgs),
    Views(views::ViewsArgs),
    #[command(subcommand)]
    Map(map::MapCommand),
    #[command(subcommand)]
    Dataset(dataset::DatasetCommand),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
}

impl Cli {
    /// Runs the requested command.
    pub fn run(self) -> Result<(), Failure> {
        process::limit_is_an_error()?;
        if let Some(n) = process::start_threads(self.threads.map(usize::from))? {
            eprintln!("note: {n} threads: more do not help here");
        }
        match self.command {
            Command::Scan(args) => args.run(),
            Command::Export(args) => args.run(),
            Command::Inspect(args) => args.run(),
            Command::Bench(args) => args.run(),
            Command::Merge(args) => args.run(),
            Command::Serve(args) => args.run(),
            Command::Plan(args) => args.run(),
            Command::Views(args) => args.run(),
            Command::Map(command) => command.run(),
            Command::Dataset(command) => command.run(),
            Command::Report(args) => args.run(),
            Command::Compare(args) => args.run(),
            Command::Completions(args) => args.run(Self::command()),
            Command::Man(args) => args.run(Self::command()),
        }
    }
}
