use super::WorkSource;
use super::queue::{Queue, Task};
use super::run::{Prepared, is_complete, measured, prepare};
use crate::{Host, Run};
use nextview::Cancel;
use nextview_scan::{Fault, TruthCache};

/// Executes all runs of a source, `n_jobs` in parallel, each with its share of the threads.
///
/// A run that fails or panics has a record with the reason. Truths in the cache, if any, are not computed;
/// results are the same. If cancelled, runs in progress are dropped without a record. A fault of the source
/// stops the other jobs after their current runs.
pub fn execute<W: WorkSource + ?Sized>(
    work: &W,
    n_jobs: usize,
    truths: Option<&TruthCache>,
    cancel: &Cancel,
) -> Result<(), Fault> {
    let n_jobs = n_jobs.max(1);
    let host = Host::this((rayon::current_num_threads() / n_jobs).max(1));
    let take = || work.take();
    let queue = Queue::new(&take);
    let job = || job(work, &queue, &host, (n_jobs == 1, truths), cancel).inspect_err(|_| queue.stop());
    std::thread::scope(|scope| {
        let spawn = |_| {
            std::thread::Builder::new().spawn_scoped(scope, job).map_err(|error| {
                queue.stop();
                Fault::data(format!("a thread cannot be started: {error}"))
                    .with_remedy("use fewer jobs (`jobs`)")
            })
        };
        let jobs: Vec<_> = (0..n_jobs).map(spawn).collect();
        let ends = jobs.into_iter().map(|job| job?.join().expect("panics are caught in the job"));
        // All jobs are awaited before the first fault is returned.
        ends.fold(Ok(()), Result::and)
    })
}

/// Executes tasks until none are left.
fn job<W: WorkSource + ?Sized>(
    work: &W,
    queue: &Queue<'_, Run, Prepared>,
    host: &Host,
    (is_alone, truths): (bool, Option<&TruthCache>),
    cancel: &Cancel,
) -> Result<(), Fault> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(host.n_threads).build().map_err(Fault::data)?;
    while !cancel.is_cancelled()
        && let Some(task) = queue.next()?
    {
        match task {
            // Uses all threads: other jobs may have to wait for it.
            Task::Prepare(group, run) => queue.prepared(group, prepare(&run.config, truths, cancel)),
            Task::Run(run, prepared) => {
                let record = pool.install(|| measured(&run, &prepared, host, is_alone, cancel));
                if !cancel.is_cancelled() || is_complete(&record) {
                    work.finish(record)?;
                }
            }
        }
    }
    Ok(())
}
