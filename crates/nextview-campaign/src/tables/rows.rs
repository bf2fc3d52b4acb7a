use super::columns::{all_steps, identity, measure_columns, name_of, quality_columns, step_identity};
use super::config::{ConfigKeys, config_columns};
use super::{Column, Table};
use crate::RunRecord;
use nextview_scan::{Fault, ScanRecord, StepRecord};

/// Creates a row per run. Equal campaigns give equal rows.
pub fn runs(records: &[&RunRecord]) -> Result<Table, Fault> {
    let mut keys = ConfigKeys::default();
    records.iter().try_for_each(|record| keys.add(&record.config))?;
    runs_with(&keys, records)
}

/// A row per run, with columns for these keys of the configuration.
pub(super) fn runs_with(keys: &ConfigKeys, records: &[&RunRecord]) -> Result<Table, Fault> {
    let mut table = identity(records.iter().copied());
    config_columns(&mut table, keys, records)?;
    let scans = || records.iter().map(|record| Some(&record.done()?.record));
    let builds: Vec<String> = records.iter().map(|record| record.build.to_string()).collect();
    table.text("build", builds.iter().map(String::as_str));
    table.text("status", scans().map(|scan| if scan.is_some() { "done" } else { "failed" }));
    table.text("reason", records.iter().map(|record| record.failure()));
    table.count("object_voxels", scans().map(|scan| scan?.object_voxels));
    table.count("reachable_voxels", scans().map(|scan| scan?.reachable_voxels));
    let stop_reasons =
        scans().map(|scan| scan.and_then(|scan| scan.stop_reason.as_ref()).map(name_of).transpose());
    table.push("stop_reason", Column::Text(stop_reasons.collect::<Result<_, _>>()?));
    table.count("views", scans().map(|scan| Some(scan?.steps.len())));
    table.count("frames_set_aside", scans().map(|scan| scan?.frames_set_aside));
    measure_columns(&mut table, || scans().map(|scan| scan?.steps.last()));
    quality_columns(&mut table, scans);
    table.float("skill", scans().map(|scan| scan?.skill));
    table.float("coverage_auc_views", scans().map(|scan| scan?.coverage_auc_views));
    table.float("coverage_auc_time", scans().map(|scan| scan?.coverage_auc_time));
    for (name, share) in [("views_to_90", 0.90), ("views_to_95", 0.95), ("views_to_99", 0.99)] {
        table.count(name, scans().map(|scan| views_to(scan?, share)));
    }
    Ok(table)
}

/// Creates a row per view of every finished run. Equal campaigns give equal rows.
pub fn steps(records: &[&RunRecord]) -> Result<Table, Fault> {
    let steps = || all_steps(records).map(|(_, step)| step);
    let mut table = step_identity(records);
    table.count("view", steps().map(|step| step.view));
    table.float("voxel_size_m", steps().map(|step| step.voxel_size_m));
    measure_columns(&mut table, || steps().map(Some));
    let verdicts = steps().map(|step| step.registration_verdict.as_ref().map(name_of).transpose());
    table.push("registration_verdict", Column::Text(verdicts.collect::<Result<_, _>>()?));
    Ok(table)
}

/// Creates a row per view with the values that differ between equal campaigns.
pub fn times(records: &[&RunRecord]) -> Table {
    let steps = || all_steps(records);
    let mut table = step_identity(records);
    table.float("plan_time_ms", steps().map(|(_, step)| step.plan_time_ms));
    table.float("map_time_ms", steps().map(|(_, step)| step.map_time_ms));
    table.float("capture_time_ms", steps().map(|(_, step)| step.capture_time_ms));
    table.float("extra_memory_mb", steps().map(|(record, _)| record.done()?.extra_memory_mb));
    table.text("host", steps().map(|(record, _)| record.host.name.as_str()));
    table.text("cpu", steps().map(|(record, _)| record.host.cpu.as_str()));
    table.count("n_threads", steps().map(|(record, _)| record.host.n_threads));
    table
}

/// Number of views until this share of the reachable surface was seen.
fn views_to(scan: &ScanRecord, share: f64) -> Option<usize> {
    let is_reached = |step: &StepRecord| step.reachable_coverage.is_some_and(|coverage| coverage >= share);
    scan.steps.iter().position(is_reached).map(|i| i + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_to_a_share_are_those_of_the_first_view_that_reaches_it() {
        let step = |reachable_coverage| StepRecord { reachable_coverage, ..StepRecord::default() };
        let steps = [Some(0.2), None, Some(0.9), Some(0.7), Some(0.96)].map(step).to_vec();
        let scan = ScanRecord { steps, ..ScanRecord::default() };
        let views = [0.1, 0.5, 0.9, 0.95, 0.97].map(|share| views_to(&scan, share));
        assert_eq!(views, [Some(1), Some(3), Some(3), Some(5), None]);
    }
}
