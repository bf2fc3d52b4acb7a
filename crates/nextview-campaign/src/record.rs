use crate::{Host, RunId};
use nextview_scan::{BuildIdentity, ScanConfig, ScanRecord};
use serde::{Deserialize, Serialize};

/// The stored result of a run: a line of `runs.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Name of the object: its file name without the extension, or the name of the built-in object.
    pub object: String,
    /// Name of the folder of the object's file, or `builtin`.
    pub data_set: String,
    /// Label of the planner and its parameters in the specification.
    pub variant: String,
    /// Seed from the specification's list: the number of a repetition with other random draws. The seeds of
    /// the draws are in `config`.
    pub seed: u64,
    /// Seed of the set of candidates; 0 in records of builds that did not write it.
    #[serde(default)]
    pub view_seed: u64,
    /// Number of the scan's first view.
    pub first_view: usize,
    /// The configuration that determines the run.
    pub config: ScanConfig,
    /// The program that computed it.
    pub build: BuildIdentity,
    /// The machine that computed it.
    pub host: Host,
    /// The outcome of the run.
    pub result: RunResult,
}

/// The outcome of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum RunResult {
    /// Finished, with measures.
    Done(Box<DoneRun>),
    /// Failed, for this reason.
    Failed(String),
}

/// The measurements of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoneRun {
    /// The scan; its final cloud is measured, no mesh is made.
    pub record: ScanRecord,
    /// Growth of the process's peak memory in the run; `None` if runs took place in parallel, or if the
    /// system does not report it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extra_memory_mb: Option<f64>,
}

impl RunRecord {
    /// Returns the identity of the run.
    pub fn id(&self) -> RunId {
        RunId {
            variant: self.variant.clone(),
            object: self.object.clone(),
            seed: self.seed,
            view_seed: self.view_seed,
            first_view: self.first_view,
        }
    }

    /// Returns the measures; `None` if the run failed.
    pub fn done(&self) -> Option<&DoneRun> {
        match &self.result {
            RunResult::Done(done) => Some(done),
            RunResult::Failed(_) => None,
        }
    }

    /// Returns the reason for a failure; `None` if the run succeeded.
    pub fn failure(&self) -> Option<&str> {
        match &self.result {
            RunResult::Done(_) => None,
            RunResult::Failed(reason) => Some(reason),
        }
    }

    /// Returns whether both have the same result, ignoring times and memory, which differ between equal runs.
    pub fn has_same_results(&self, other: &Self) -> bool {
        timeless(&self.result) == timeless(&other.result)
    }
}

/// The result without times and memory.
fn timeless(result: &RunResult) -> RunResult {
    let mut result = result.clone();
    if let RunResult::Done(done) = &mut result {
        done.extra_memory_mb = None;
        (done.record.baseline_time_ms, done.record.peak_memory_mb) = (None, None);
        for step in &mut done.record.steps {
            (step.plan_time_ms, step.map_time_ms, step.capture_time_ms) = (0.0, 0.0, 0.0);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn times_and_memory_are_no_results() {
        let run = synthetic::campaign(&["a"], 1).remove(0);
        let mut other = run.clone();
        let done = synthetic::done_mut(&mut other);
        done.extra_memory_mb = None;
        done.record.peak_memory_mb = Some(7.0);
        done.record.steps[1].plan_time_ms += 1.0;
        assert!(run != other && run.has_same_results(&other));
        synthetic::done_mut(&mut other).record.steps[1].entropy_nats += 1.0;
        assert!(!run.has_same_results(&other));
    }

    #[test]
    fn what_is_written_reads_back_to_the_same_bits() {
        let mut runs = synthetic::campaign(&["a", "b"], 2);
        runs[1].result = RunResult::Failed("no \"luck\"\n".to_owned());
        for run in runs {
            let line = serde_json::to_string(&run).unwrap();
            assert!(!line.contains('\n'));
            assert_eq!(serde_json::from_str::<RunRecord>(&line).unwrap(), run);
        }
    }
}
