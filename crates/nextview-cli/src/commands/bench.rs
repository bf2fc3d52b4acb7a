use super::campaign::{check, counted};
use super::values;
use crate::progress::CampaignProgress;
use crate::{Failure, interrupt, stdout};
use clap::Args;
use indicatif::HumanDuration;
use nextview::Cancel;
use nextview_campaign::execution::{CampaignEvent, run_campaign};
use nextview_campaign::store::{self, Store, config_of_row};
use nextview_campaign::{Shard, Spec, builtin, tables};
use nextview_scan::TruthCache;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Run a campaign: many scans of many objects by several planners, measured in the same way.
///
/// A specification names the objects, the planners with their parameters, the seeds, the sets of candidates
/// and the first views; all combinations are run. Failures are recorded and do not stop the rest. --resume
/// resumes an interrupted campaign; the results are the same, for any number of jobs and threads.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct BenchArgs {
    /// A TOML file or a built-in specification (see --list)
    #[arg(value_parser = values::file_name())]
    spec: Option<String>,
    /// Mesh files or builtin:NAME (see scan), instead of the objects of the specification
    #[arg(value_parser = values::file_name())]
    mesh: Vec<String>,
    /// Folder for the results [default: bench-NAME, followed by -2, -3, ... if that holds a finished
    /// campaign]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of runs in parallel [default: one per thread]; with 1, times and memory are those of a single
    /// run
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Run only shard K of N, counted from 1; `nextview merge` combines all shards [default folder:
    /// bench-NAME-K-of-N]
    #[arg(long, value_name = "K/N", value_parser = values::shard)]
    shard: Option<Shard>,
    /// Cache the true visibility of every object from all candidates in this folder, so that it is computed
    /// once for all campaigns and shards; the results are the same
    #[arg(long, value_name = "DIR")]
    truth_cache: Option<PathBuf>,
    /// Maximum size of that folder; the least recently used entries are removed
    #[arg(long, value_name = "MB", default_value_t = TruthCache::DEFAULT_MB, requires = "truth_cache")]
    truth_cache_mb: u64,
    /// Resume the campaign in the folder; SPEC can then be omitted
    #[arg(long)]
    resume: bool,
    /// Print the configuration of the run in this row of runs.csv, from 1, for scan --config
    #[arg(long, value_name = "ROW", conflicts_with_all = ["jobs", "resume", "shard", "truth_cache", "list"])]
    config_of: Option<usize>,
    /// Show the built-in specifications
    #[arg(long, conflicts_with_all = ["spec", "out", "jobs", "resume", "shard", "truth_cache"])]
    list: bool,
}

const EXAMPLES: &str = "\
Examples:
  nextview bench paper-1                            the paper's table I, on the built-in objects
  nextview bench paper-1 meshes/*.ply --out mine    on your own
  nextview bench mine.toml --jobs 4                 your own specification
  nextview bench --resume --out mine                resume after an interruption
  nextview bench mine.toml --shard 3/64 --out 3     one shard of the runs; then: nextview merge 1 2 3 ...
  nextview bench --out mine --config-of 3           the configuration of the run in row 3 of runs.csv

A specification (keys of `scan` as in config.toml; see docs/bench.md):
  name = \"mine\"
  first_views = 3
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
            let line = |(name, about)| format!("{name}  {about}\n");
            return stdout::print(builtin::list().map(line).collect::<String>());
        }
        let start = Instant::now();
        let spec = self.specification()?;
        let is_last = self.resume || self.config_of.is_some();
        let dir = self.out.unwrap_or_else(|| match self.shard {
            Some(shard) => store::shard_folder(&spec.name, shard),
            None => store::campaign_folder(&spec.name, is_last),
        });
        if let Some(row) = self.config_of {
            return stdout::print(config_of_row(&dir, row)?);
        }
        let truths = self.truth_cache.map(|dir| TruthCache::open(&dir, self.truth_cache_mb)).transpose()?;
        let mut store = Store::open(&dir, &spec, self.shard.unwrap_or(Shard::WHOLE), self.resume)?;
        interrupt::resumable("nextview bench --resume --out", &dir, dir.clone());
        let n_runs = store.share().iter().map(Vec::len).sum();
        let progress = CampaignProgress::new(n_runs);
        let on_event = |event| on_event(event, &progress, &spec.name, &dir);
        let jobs = self.jobs.map(usize::from);
        run_campaign(&mut store, jobs, truths.as_ref(), &Cancel::default(), &on_event)?;
        drop(progress);
        let (done, time, shown) = (counted(n_runs, "run"), HumanDuration(start.elapsed()), dir.display());
        if let Some(shard) = self.shard {
            stdout::print(format!("\n{done}, {time}; shard {shard} in {shown}; next: nextview merge\n"))?;
        } else {
            tables::write(&dir, &store.finished())?;
            stdout::print(format!(
                "\n{done}, {time}; results in {shown} (runs, steps and times, as .csv and .parquet)\n\
                 to repeat a run: nextview bench --out {shown} --config-of ROW > run.toml; nextview scan --config run.toml\n"
            ))?;
        }
        check(&store.failed(), n_runs)
    }

    fn specification(&self) -> Result<Spec, Failure> {
        match (&self.spec, &self.out) {
            (Some(spec), _) => Ok(Spec::load(spec, &self.mesh)?),
            (None, Some(dir)) if self.resume || self.config_of.is_some() => Ok(Spec::of_folder(dir)?),
            (None, _) => Err(Failure::usage("no specification is given").with_hint(
                "pass a TOML file or the name of a built-in one (--list shows them), or --resume and --out",
            )),
        }
    }
}

/// Shows an event of the campaign. A closed stdout does not end the campaign.
fn on_event(event: CampaignEvent, progress: &CampaignProgress, name: &str, dir: &Path) {
    let text = match event {
        CampaignEvent::Began { n_objects, n_runs, n_finished } => {
            progress.begin(n_finished);
            let before = if n_finished > 0 { format!(", {n_finished} already done") } else { String::new() };
            let (objects, runs) = (counted(n_objects, "object"), counted(n_runs, "run"));
            format!("{name}: {objects}, {runs}{before}, in {}\n", dir.display())
        }
        CampaignEvent::RunFinished { .. } => return progress.step(),
        CampaignEvent::ObjectFinished { object, n_runs, n_failed: 0 } => {
            format!("{object}: {}\n", counted(n_runs, "run"))
        }
        CampaignEvent::ObjectFinished { object, n_runs, n_failed } => {
            format!("{object}: {}, {n_failed} failed\n", counted(n_runs, "run"))
        }
        CampaignEvent::Note(note) => return eprintln!("note: {note}"),
        _ => return,
    };
    let _ = progress.print(&text);
}
