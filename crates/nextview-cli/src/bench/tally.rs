//! What is told of a campaign on the way and at the end.

use super::RunRecord;
use super::campaign::Run;
use super::spec::Spec;
use crate::Failure;
use std::collections::BTreeMap;
use std::path::Path;

/// How many runs of each object are left and how many failed.
pub(super) struct Tally<'a> {
    runs: &'a [Run],
    objects: BTreeMap<&'a str, Count>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    n_runs: usize,
    n_left: usize,
    n_failed: usize,
}

impl<'a> Tally<'a> {
    pub fn new(runs: &'a [Run], records: &[Option<RunRecord>]) -> Self {
        let mut objects: BTreeMap<&str, Count> = BTreeMap::new();
        for (run, record) in runs.iter().zip(records) {
            let count = objects.entry(&run.id.object).or_default();
            count.n_runs += 1;
            count.n_left += usize::from(record.is_none());
            count.n_failed += usize::from(record.as_ref().is_some_and(|record| record.failure().is_some()));
        }
        Self { runs, objects }
    }

    /// Counts a run; a line to print if it was the last of its object.
    pub fn add(&mut self, run: usize, record: &RunRecord) -> Option<String> {
        let name = self.runs[run].id.object.as_str();
        let count = self.objects.get_mut(name)?;
        count.n_left -= 1;
        count.n_failed += usize::from(record.failure().is_some());
        (count.n_left == 0).then(|| match count.n_failed {
            0 => format!("{name}: {}\n", counted(count.n_runs, "run")),
            n_failed => format!("{name}: {}, {n_failed} failed\n", counted(count.n_runs, "run")),
        })
    }
}

/// What the campaign is.
pub(super) fn heading(spec: &Spec, runs: &[Run], records: &[Option<RunRecord>], dir: &Path) -> String {
    let n_done = records.iter().flatten().count();
    let n_objects = spec.objects.len();
    let before = if n_done > 0 { format!(", {n_done} done before") } else { String::new() };
    format!(
        "{}: {}, {}{before}, in {}\n",
        spec.name,
        counted(n_objects, "object"),
        counted(runs.len(), "run"),
        dir.display()
    )
}

/// Fails with the reasons if any run failed.
pub(super) fn check(records: &[RunRecord]) -> Result<(), Failure> {
    let mut reasons: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for record in records {
        if let Some(reason) = record.failure() {
            *reasons.entry((&record.object, reason)).or_default() += 1;
        }
    }
    if reasons.is_empty() {
        return Ok(());
    }
    let n_failed: usize = reasons.values().sum();
    let lines = reasons
        .iter()
        .map(|((object, reason), n)| format!("\n  {object} ({}): {reason}", counted(*n, "run")));
    Err(Failure::data(format!("{n_failed} of {} runs failed{}", records.len(), lines.collect::<String>())))
}

/// `1 run`, `2 runs`.
pub(super) fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}
