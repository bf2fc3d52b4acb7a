//! Code shared by the commands for campaigns.

use crate::Failure;
use nextview_campaign::FailedRuns;

/// Fails with the reasons if any run failed.
pub(super) fn check(failed: &[FailedRuns], n_runs: usize) -> Result<(), Failure> {
    if failed.is_empty() {
        return Ok(());
    }
    let n_failed: usize = failed.iter().map(|failed| failed.n_runs).sum();
    let line = |FailedRuns { object, reason, n_runs }: &FailedRuns| {
        format!("\n  {object} ({}): {reason}", counted(*n_runs, "run"))
    };
    let lines: String = failed.iter().map(line).collect();
    Err(Failure::data(format!("{n_failed} of {n_runs} runs failed{lines}")))
}

/// `1 run`, `2 runs`.
pub(super) fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}
