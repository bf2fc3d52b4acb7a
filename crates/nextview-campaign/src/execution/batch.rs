use super::run::{Prepared, is_complete, measured, prepare};
use crate::{Host, Run, RunRecord};
use nextview::Cancel;
use nextview_scan::{BuildIdentity, Fault, Faults, TruthCache};
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeSet, VecDeque};
use std::fmt;

/// Maximum number of variants listed in the name of a batch.
const MAX_NAMED: usize = 3;

/// Runs with a common object, on their way to a worker in another process.
///
/// Its `Display` names the object and the variants, for a list of tasks: `mug: max-flow, random`.
///
/// ```
/// use nextview_campaign::Spec;
/// use nextview_campaign::execution::Batch;
///
/// let spec = "name = \"x\"\nobjects = [\"builtin:mug\"]\nseeds = [0, 1]\nscan.planner = \"random\"";
/// let batch = Batch::new(Spec::parse(spec, "".as_ref())?.runs()?.iter().collect());
/// assert_eq!(batch.to_string(), "mug: random");
/// assert_eq!(Batch::from_json(&batch.to_json()?)?, batch);
/// # Ok::<(), nextview_scan::Faults>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    runs: Vec<Run>,
}

/// A batch as written. The build is checked before the runs are read: another build may write them
/// differently.
#[derive(Serialize, Deserialize)]
struct BatchMessage<R> {
    build: BuildIdentity,
    runs: R,
}

impl Batch {
    /// Creates a batch of these runs, which must have a common object
    /// ([`ScanConfig::of_object`](nextview_scan::ScanConfig::of_object)): it is prepared once for all of
    /// them.
    pub fn new(runs: Vec<Run>) -> Self {
        Self { runs }
    }

    /// Returns the runs, in execution order.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Returns the batch as JSON, for [`Batch::from_json`].
    pub fn to_json(&self) -> Result<String, Fault> {
        let message = BatchMessage { build: BuildIdentity::this(), runs: &self.runs };
        serde_json::to_string(&message).map_err(Fault::data)
    }

    /// Reads a batch; fails if another build wrote it, because that build could not use the records.
    pub fn from_json(text: &str) -> Result<Self, Fault> {
        let unreadable = |error| Fault::data(format!("a batch of runs cannot be read: {error}"));
        let BatchMessage { build, runs }: BatchMessage<Value> =
            serde_json::from_str(text).map_err(unreadable)?;
        let this = BuildIdentity::this();
        if build != this {
            let host = Host::this(1).name;
            let message = format!(
                "the campaign was started by build {build}, but the worker on {host} has build {this}"
            );
            return Err(Fault::data(message).with_remedy("install the same build everywhere"));
        }
        Ok(Self { runs: serde_json::from_value(runs).map_err(unreadable)? })
    }

    /// Prepares the execution of the runs, with `n_threads` threads each; a cache, if given, provides the
    /// truth of their object. Fails if the runs cannot be done here, for example because a user's planner is
    /// missing: every run would fail, and stay failed.
    pub fn begin(self, n_threads: usize, truths: Option<TruthCache>) -> Result<BatchRuns, Faults> {
        for run in &self.runs {
            let worker = || format!("the worker on {}", Host::this(1).name);
            let within = |faults: Faults| faults.map(|fault| fault.within(worker()));
            run.config.check_with_files().map_err(within)?;
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads.max(1)).build();
        Ok(BatchRuns {
            open: self.runs.into(),
            prepared: None,
            truths,
            host: Host::this(n_threads.max(1)),
            pool: pool.map_err(Fault::data)?,
        })
    }
}

impl fmt::Display for Batch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(first) = self.runs.first() else { return f.write_str("no runs") };
        let variants: BTreeSet<&str> = self.runs.iter().map(|run| run.id.variant.as_str()).collect();
        let named: Vec<&str> = variants.iter().copied().take(MAX_NAMED).collect();
        write!(f, "{}: {}", first.id.object, named.join(", "))?;
        match variants.len() - named.len() {
            0 => Ok(()),
            n_more => write!(f, " and {n_more} more"),
        }
    }
}

/// The runs of a batch, executed one after the other by a process that does nothing else meanwhile.
pub struct BatchRuns {
    open: VecDeque<Run>,
    /// `None` before the first run.
    prepared: Option<Prepared>,
    truths: Option<TruthCache>,
    host: Host,
    pool: ThreadPool,
}

impl BatchRuns {
    /// Executes the next run; `None` if all are done. A run that fails or panics has a record with the
    /// reason. If cancelled, this fails, and the run stays open.
    pub fn next_record(&mut self, cancel: &Cancel) -> Result<Option<RunRecord>, Fault> {
        let Some(run) = self.open.front() else { return Ok(None) };
        let Self { prepared, truths, host, pool, .. } = self;
        let prepared = match prepared {
            Some(prepared) => prepared,
            None => {
                let made = pool.install(|| prepare(&run.config, truths.as_ref(), cancel));
                cancel.check()?;
                prepared.insert(made)
            }
        };
        let record = pool.install(|| measured(run, prepared, host, true, cancel));
        if !is_complete(&record) {
            cancel.check()?;
        }
        self.open.pop_front();
        Ok(Some(record))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spec;
    use std::path::Path;

    fn batch() -> Batch {
        let text = "name = \"x\"\nobjects = [\"builtin:mug\"]\n[scan]\nviews = 2\ncandidates = 20\n\
                    voxel_size_m = 0.02\n[[variant]]\n\
                    sweep.planner = [\"random\", \"rse\", \"apora\", \"max-flow\"]";
        Batch::new(Spec::parse(text, Path::new("")).unwrap().runs().unwrap().iter().collect())
    }

    #[test]
    fn its_name_says_object_and_variants() {
        let all = batch();
        assert_eq!(all.to_string(), "mug: apora, max-flow, random and 1 more");
        assert_eq!(Batch::new(all.runs[..1].to_vec()).to_string(), "mug: random");
        assert_eq!(Batch::new(Vec::new()).to_string(), "no runs");
    }

    #[test]
    fn another_build_is_refused_with_both_builds() {
        let text = batch().to_json().unwrap();
        let this = BuildIdentity::this();
        let other = text.replacen(&this.source, "feedfacebeef", 1).replacen("\"runs\":[", "\"runs\":[7,", 1);
        let message = Batch::from_json(&other).unwrap_err().message;
        assert!(message.contains(&format!("build {} (feedfacebeef)", this.version)), "{message}");
        assert!(message.contains(&format!(" has build {this}")), "{message}");
        let unreadable = Batch::from_json("{}").unwrap_err().message;
        assert!(unreadable.starts_with("a batch of runs cannot be read: missing field"), "{unreadable}");
    }

    #[test]
    fn what_cannot_be_done_here_is_no_failed_run() {
        let mut other = batch();
        other.runs[1].config.voxel_size_m = Some(-1.0);
        let message = other.begin(1, None).err().unwrap().to_string();
        assert!(message.contains("the worker on ") && message.contains("`voxel_size_m` is -1"), "{message}");
    }

    #[test]
    fn a_run_that_was_cancelled_stays_open() {
        let mut runs = batch().begin(1, None).unwrap();
        let cancel = Cancel::default();
        cancel.cancel();
        runs.next_record(&cancel).unwrap_err();
        cancel.reset();
        let mut variants = Vec::new();
        while let Some(record) = runs.next_record(&cancel).unwrap() {
            assert_eq!((record.failure(), record.host.n_threads), (None, 1));
            variants.push(record.variant);
        }
        assert_eq!(variants, ["random", "rse", "apora", "max-flow"]);
    }
}
