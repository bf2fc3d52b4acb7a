use super::{Column, Table};
use crate::RunRecord;
use nextview_scan::{Fault, QualityMm, ScanRecord, StepRecord};
use serde::Serialize;
use toml::Value;

/// The columns that identify a run.
pub(super) fn identity<'a>(records: impl Iterator<Item = &'a RunRecord> + Clone) -> Table {
    let mut table = Table::default();
    table.text("object", records.clone().map(|r| r.object.as_str()));
    table.text("data_set", records.clone().map(|r| r.data_set.as_str()));
    table.text("variant", records.clone().map(|r| r.variant.as_str()));
    // Seeds are below 2^63, the largest integer of a TOML file.
    table.push("seed", Column::Int(records.clone().map(|r| Some(r.seed as i64)).collect()));
    table.push("view_seed", Column::Int(records.clone().map(|r| Some(r.view_seed as i64)).collect()));
    table.count("first_view", records.map(|r| r.first_view));
    table
}

/// The columns that identify a step of a run.
pub(super) fn step_identity(records: &[&RunRecord]) -> Table {
    let mut table = identity(all_steps(records).map(|(record, _)| record));
    table.count("step", all_steps(records).map(|(_, step)| step.step));
    table
}

/// Every step of every finished run.
pub(super) fn all_steps<'a>(
    records: &[&'a RunRecord],
) -> impl Iterator<Item = (&'a RunRecord, &'a StepRecord)> + Clone {
    let done = records.iter().filter_map(|record| Some((*record, &record.done()?.record.steps)));
    done.flat_map(|(record, steps)| steps.iter().map(move |step| (record, step)))
}

/// The measures after a view, except times.
pub(super) fn measure_columns<'a, I: Iterator<Item = Option<&'a StepRecord>>>(
    table: &mut Table,
    steps: impl Fn() -> I,
) {
    table.float("voxel_coverage", steps().map(|s| s?.voxel_coverage));
    table.count("false_voxels", steps().map(|s| s?.false_voxels));
    table.float("map_precision", steps().map(|s| s?.map_precision));
    table.float("map_recall", steps().map(|s| s?.map_recall));
    table.float("map_iou", steps().map(|s| s?.map_iou));
    table.float("reachable_coverage", steps().map(|s| s?.reachable_coverage));
    table.float("estimated_completeness", steps().map(|s| s?.estimated_completeness));
    table.float("expected_new_voxels", steps().map(|s| s?.expected_new_voxels));
    table.float("surface_coverage_1mm", steps().map(|s| s?.surface_coverage_1mm));
    table.float("surface_coverage_2mm", steps().map(|s| s?.surface_coverage_2mm));
    table.float("surface_coverage_5mm", steps().map(|s| s?.surface_coverage_5mm));
    table.float("misplaced_mm", steps().map(|s| s?.misplaced_mm));
    table.float("registration_overlap", steps().map(|s| s?.registration_overlap));
    table.float("entropy_nats", steps().map(|s| Some(s?.entropy_nats)));
    table.float("entropy_share", steps().map(|s| Some(s?.entropy_share)));
    table.float("path_length_m", steps().map(|s| Some(s?.path_length_m)));
    table.float("trajectory_length_m", steps().map(|s| Some(s?.trajectory_length_m)));
    table.float("trajectory_time_s", steps().map(|s| Some(s?.trajectory_time_s)));
}

/// Quality of the final cloud.
pub(super) fn quality_columns<'a, I: Iterator<Item = Option<&'a ScanRecord>>>(
    table: &mut Table,
    scans: impl Fn() -> I,
) {
    let cloud = |of: fn(QualityMm) -> f64| scans().map(move |scan| scan?.cloud().map(of));
    let known = |of: fn(QualityMm) -> Option<f64>| scans().map(move |scan| scan?.cloud().and_then(of));
    table.float("cloud_accuracy_mean_mm", cloud(|cloud| cloud.accuracy_mean_mm));
    table.float("cloud_accuracy_median_mm", cloud(|cloud| cloud.accuracy_median_mm));
    table.float("cloud_accuracy_p95_mm", cloud(|cloud| cloud.accuracy_p95_mm));
    table.float("cloud_precision_1mm", known(|cloud| cloud.precision_1mm));
    table.float("cloud_precision_2mm", known(|cloud| cloud.precision_2mm));
    table.float("cloud_precision_5mm", known(|cloud| cloud.precision_5mm));
    table.float("cloud_completeness_1mm", cloud(|cloud| cloud.completeness_1mm));
    table.float("cloud_completeness_2mm", cloud(|cloud| cloud.completeness_2mm));
    table.float("cloud_completeness_5mm", cloud(|cloud| cloud.completeness_5mm));
    table.float("cloud_completeness_mean_mm", cloud(|cloud| cloud.completeness_mean_mm));
    table.float("cloud_recall_1mm", known(|cloud| cloud.recall_1mm));
    table.float("cloud_recall_2mm", known(|cloud| cloud.recall_2mm));
    table.float("cloud_recall_5mm", known(|cloud| cloud.recall_5mm));
    let of_reachable = known(|cloud| cloud.reachable_completeness_mean_mm);
    table.float("cloud_reachable_completeness_mean_mm", of_reachable);
    table.float("cloud_f_score_1mm", known(|cloud| cloud.f_score_1mm));
    table.float("cloud_f_score_2mm", known(|cloud| cloud.f_score_2mm));
    table.float("cloud_f_score_5mm", known(|cloud| cloud.f_score_5mm));
    table.float("cloud_chamfer_mm", known(|cloud| cloud.chamfer_mm));
    table.float("alignment_moved_mm", scans().map(|scan| scan?.alignment_moved_mm));
    table.float("alignment_turned_deg", scans().map(|scan| scan?.alignment_turned_deg));
}

/// The name that serde gives a value.
pub(super) fn name_of(value: &impl Serialize) -> Result<String, Fault> {
    let value = Value::try_from(value).map_err(Fault::data)?;
    Ok(value.as_str().unwrap_or_default().to_owned())
}
