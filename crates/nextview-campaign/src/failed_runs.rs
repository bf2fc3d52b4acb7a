use crate::RunRecord;
use std::collections::BTreeMap;

/// Runs of one object that failed for the same reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailedRuns {
    /// Name of the object.
    pub object: String,
    /// Why they failed.
    pub reason: String,
    /// How many they are.
    pub n_runs: usize,
}

/// All runs that failed, by object and reason; empty if all were done.
pub fn failed_runs(records: &[&RunRecord]) -> Vec<FailedRuns> {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for record in records {
        if let Some(reason) = record.failure() {
            *counts.entry((&record.object, reason)).or_default() += 1;
        }
    }
    let failed = |((object, reason), n_runs): ((&str, &str), usize)| FailedRuns {
        object: object.to_owned(),
        reason: reason.to_owned(),
        n_runs,
    };
    counts.into_iter().map(failed).collect()
}
