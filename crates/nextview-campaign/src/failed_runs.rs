use crate::RunRecord;
use std::collections::BTreeMap;

/// Runs of an object that failed for the same reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailedRuns {
    /// Name of the object.
    pub object: String,
    /// The reason for their failure.
    pub reason: String,
    /// Number of runs.
    pub n_runs: usize,
}

/// Numbers of failed runs, by object and reason.
#[derive(Clone, Debug, Default)]
pub(crate) struct FailureCounts(BTreeMap<(String, String), usize>);

impl FailureCounts {
    /// Counts the run of a record if it failed.
    pub fn add(&mut self, record: &RunRecord) {
        if let Some(reason) = record.failure() {
            *self.0.entry((record.object.clone(), reason.to_owned())).or_default() += 1;
        }
    }

    /// Lists the failed runs; empty if no run failed.
    pub fn list(&self) -> Vec<FailedRuns> {
        let failed = |((object, reason), &n_runs): (&(String, String), &usize)| FailedRuns {
            object: object.clone(),
            reason: reason.clone(),
            n_runs,
        };
        self.0.iter().map(failed).collect()
    }
}
