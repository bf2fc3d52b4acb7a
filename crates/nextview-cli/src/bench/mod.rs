//! `nextview bench`: campaigns of many scans by one specification, and what is kept of them.

mod builtin;
mod campaign;
mod execute;
mod folder;
mod host;
mod object;
mod pattern;
mod progress;
mod queue;
mod record;
mod spec;
mod table;
mod tables;
mod tally;
mod variant;

pub(crate) use builtin::list;
pub(crate) use record::{Host, Measures, RunRecord, RunResult, StepMeasures};

use crate::{Failure, stdout};
use campaign::Run;
use folder::Folder;
use indicatif::HumanDuration;
use progress::Progress;
use queue::{Queue, Task};
use spec::Spec;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use tally::Tally;

/// What to do, and where the results go.
#[derive(Debug)]
pub(crate) struct Request {
    /// A built-in specification or a file; that of the folder if there is none.
    pub spec: Option<String>,
    /// Objects in place of those of the specification.
    pub meshes: Vec<String>,
    /// The folder; by default it is named after the specification.
    pub out: Option<PathBuf>,
    /// Runs beside each other; by default one per thread.
    pub jobs: Option<usize>,
    /// Whether to go on with a campaign that is in the folder.
    pub resume: bool,
}

/// Does what is left of the campaign, then writes its tables. Fails at the end if any run failed.
pub(crate) fn bench(request: &Request) -> Result<(), Failure> {
    let start = Instant::now();
    let (spec, place) = specification(request)?;
    let runs = campaign::runs(&spec).map_err(|failure| failure.in_file(&place))?;
    let dir = request.out.clone().unwrap_or_else(|| PathBuf::from(format!("bench-{}", spec.name)));
    let mut folder = Folder::open(&dir, &spec, request.resume)?;
    let records = folder.records(&runs)?;
    stdout::print(tally::heading(&spec, &runs, &records, &dir))?;
    let n_jobs = request.jobs.unwrap_or_else(rayon::current_num_threads);
    do_open(&runs, &records, &mut folder, n_jobs)?;
    let records: Vec<_> = folder.records(&runs)?.into_iter().flatten().collect();
    tables::write(&dir, &records)?;
    let time = HumanDuration(start.elapsed());
    stdout::print(format!(
        "\n{}, {time}; results in {} (runs, steps and times, as .csv and .parquet)\n",
        tally::counted(runs.len(), "run"),
        dir.display()
    ))?;
    tally::check(&records)
}

/// The specification and where it is from.
fn specification(request: &Request) -> Result<(Spec, PathBuf), Failure> {
    match (&request.spec, &request.out) {
        (Some(spec), _) => Ok((Spec::load(spec, &request.meshes)?, PathBuf::from(spec))),
        (None, Some(dir)) if request.resume => {
            let path = dir.join(folder::SPEC);
            Ok((Spec::reload(&path)?, path))
        }
        (None, _) => Err(Failure::usage("there is no specification").with_hint(
            "pass a TOML file or the name of a built-in one (--list shows them), or --resume and --out",
        )),
    }
}

/// Does the runs that have no record yet, several beside each other.
fn do_open(
    runs: &[Run],
    records: &[Option<RunRecord>],
    folder: &mut Folder,
    n_jobs: usize,
) -> Result<(), Failure> {
    let open: Vec<usize> = (0..runs.len()).filter(|&run| records[run].is_none()).collect();
    let (settings, groups) = grouped(runs, &open);
    let queue = Queue::new(groups);
    let n_jobs = n_jobs.clamp(1, open.len().max(1));
    let host = Host::this((rayon::current_num_threads() / n_jobs).max(1));
    let progress = Progress::new(runs.len(), runs.len() - open.len());
    let results = Mutex::new((folder, Tally::new(runs, records)));
    let keep = |run: usize, record: &RunRecord| {
        let (folder, tally) = &mut *results.lock().unwrap_or_else(PoisonError::into_inner);
        folder.append(record)?;
        progress.step();
        tally.add(run, record).map_or(Ok(()), |line| progress.print(&line))
    };
    let job = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(host.n_threads).build();
        let pool = pool.map_err(Failure::data)?;
        while let Some(task) = queue.next() {
            match task {
                // By all threads: other jobs may have to wait for it.
                Task::Prepare(group) => queue.prepared(group, execute::prepare(&settings[group])),
                Task::Run(run, prepared) => {
                    let record = pool.install(|| execute::execute(&runs[run], &prepared, &host, n_jobs == 1));
                    keep(run, &record)?;
                }
            }
        }
        Ok(())
    };
    let job = || job().inspect_err(|_| queue.stop());
    std::thread::scope(|scope| {
        let jobs: Vec<_> = (0..n_jobs).map(|_| scope.spawn(job)).collect();
        let ends = jobs.into_iter().map(|job| job.join().expect("panics are caught in the job"));
        // All are awaited before the first failure is told.
        ends.fold(Ok(()), Result::and)
    })
}

/// The settings of these runs, and which runs share each.
fn grouped(runs: &[Run], open: &[usize]) -> (Vec<crate::scan::ScanConfig>, Vec<Vec<usize>>) {
    let (mut settings, mut groups): (Vec<_>, Vec<Vec<usize>>) = Default::default();
    for &run in open {
        let setting = runs[run].config.of_setting();
        match settings.iter().rposition(|known| *known == setting) {
            Some(group) => groups[group].push(run),
            None => {
                settings.push(setting);
                groups.push(vec![run]);
            }
        }
    }
    (settings, groups)
}
