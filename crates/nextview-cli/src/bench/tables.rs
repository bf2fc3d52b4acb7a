//! The tables of a finished campaign.

use super::table::{Column, Table};
use super::{Measures, RunRecord, RunResult, StepMeasures};
use crate::scan::{QualityMm, ScanConfig};
use crate::{Failure, files};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Value;

/// Writes every table as CSV and as Parquet.
pub(super) fn write(dir: &Path, records: &[RunRecord]) -> Result<(), Failure> {
    let tables = [("runs", runs(records)?), ("steps", steps(records)?), ("times", times(records))];
    for (name, table) in tables {
        files::write(&dir.join(format!("{name}.csv")), |w| table.write_csv(w))?;
        files::write(&dir.join(format!("{name}.parquet")), |w| table.write_parquet(w))?;
    }
    Ok(())
}

/// A row per run. Equal campaigns give equal rows.
fn runs(records: &[RunRecord]) -> Result<Table, Failure> {
    let mut table = identity(records.iter());
    configurations(&mut table, records)?;
    let measures = || records.iter().map(RunRecord::measures);
    let last = || measures().map(|measures| measures?.steps.last());
    table.text("version", records.iter().map(|r| r.version.as_str()));
    table.text("status", records.iter().map(|r| if r.measures().is_some() { "done" } else { "failed" }));
    table.text("reason", records.iter().map(RunRecord::failure));
    table.count("n_object_voxels", measures().map(|m| Some(m?.n_object_voxels)));
    table.count("n_reachable", measures().map(|m| m?.n_reachable));
    let stop_reasons = measures().map(|m| m.map(|m| name_of(&m.stop_reason)));
    table.push("stop_reason", Column::Text(stop_reasons.map(Option::transpose).collect::<Result<_, _>>()?));
    table.count("n_views", measures().map(|m| Some(m?.steps.len())));
    step_columns(&mut table, last);
    quality_columns(&mut table, records);
    table.float("skill", measures().map(|m| m?.skill));
    for (name, share) in [("views_to_90", 0.90), ("views_to_95", 0.95), ("views_to_99", 0.99)] {
        table.count(name, measures().map(|m| views_to(m?, share)));
    }
    Ok(table)
}

/// A row per view of every run that is done.
fn steps(records: &[RunRecord]) -> Result<Table, Failure> {
    let mut table = step_identity(records);
    table.count("view", all_steps(records).map(|(.., step)| step.view));
    table.float("voxel_size_m", all_steps(records).map(|(.., step)| step.voxel_size_m));
    step_columns(&mut table, || all_steps(records).map(|(.., step)| Some(step)));
    let verdicts = all_steps(records).map(|(.., step)| step.registration.as_ref().map(name_of).transpose());
    table.push("registration", Column::Text(verdicts.collect::<Result<_, _>>()?));
    Ok(table)
}

/// The same rows with what differs from run to run of the same thing.
fn times(records: &[RunRecord]) -> Table {
    let steps = || all_steps(records);
    let mut table = step_identity(records);
    table.float("plan_time_ms", steps().map(|(.., step)| step.plan_time_ms));
    table.float("map_time_ms", steps().map(|(.., step)| step.map_time_ms));
    table.float("render_time_ms", steps().map(|(.., step)| step.render_time_ms));
    table.float("extra_memory_mb", steps().map(|(r, ..)| r.measures()?.extra_memory_mb));
    table.text("host", steps().map(|(r, ..)| r.host.name.as_str()));
    table.text("cpu", steps().map(|(r, ..)| r.host.cpu.as_str()));
    table.count("n_threads", steps().map(|(r, ..)| r.host.n_threads));
    table
}

/// What is measured after a view, times aside.
fn step_columns<'a, I: Iterator<Item = Option<&'a StepMeasures>>>(table: &mut Table, steps: impl Fn() -> I) {
    table.float("voxel_coverage", steps().map(|s| Some(s?.voxel_coverage)));
    table.count("false_voxels", steps().map(|s| Some(s?.false_voxels)));
    table.float("seen", steps().map(|s| s?.seen));
    table.float("estimated_seen_before", steps().map(|s| s?.estimated_seen_before));
    table.float("expected_new_voxels", steps().map(|s| s?.expected_new_voxels));
    table.float("surface_1mm", steps().map(|s| Some(s?.surface_1mm)));
    table.float("surface_2mm", steps().map(|s| Some(s?.surface_2mm)));
    table.float("surface_5mm", steps().map(|s| Some(s?.surface_5mm)));
    table.float("misplaced_mm", steps().map(|s| s?.misplaced_mm));
    table.float("overlap", steps().map(|s| s?.overlap));
    table.float("entropy_nats", steps().map(|s| Some(s?.entropy_nats)));
    table.float("entropy_share", steps().map(|s| Some(s?.entropy_share)));
    table.float("path_length_m", steps().map(|s| Some(s?.path_length_m)));
    table.float("way_m", steps().map(|s| s?.way_m));
    table.float("move_time_s", steps().map(|s| s?.move_time_s));
}

/// Of the final cloud.
fn quality_columns(table: &mut Table, records: &[RunRecord]) {
    let cloud = |of: fn(QualityMm) -> f64| records.iter().map(move |record| record.measures()?.cloud.map(of));
    table.float("cloud_accuracy_mean_mm", cloud(|cloud| cloud.accuracy_mean_mm));
    table.float("cloud_accuracy_median_mm", cloud(|cloud| cloud.accuracy_median_mm));
    table.float("cloud_accuracy_p95_mm", cloud(|cloud| cloud.accuracy_p95_mm));
    table.float("cloud_completeness_1mm", cloud(|cloud| cloud.completeness_1mm));
    table.float("cloud_completeness_2mm", cloud(|cloud| cloud.completeness_2mm));
    table.float("cloud_completeness_5mm", cloud(|cloud| cloud.completeness_5mm));
    table.float("cloud_completeness_mean_mm", cloud(|cloud| cloud.completeness_mean_mm));
}

/// The columns that tell a run from all others.
fn identity<'a>(records: impl Iterator<Item = &'a RunRecord> + Clone) -> Table {
    let mut table = Table::default();
    table.text("object", records.clone().map(|r| r.object.as_str()));
    table.text("data_set", records.clone().map(|r| r.data_set.as_str()));
    table.text("variant", records.clone().map(|r| r.variant.as_str()));
    // Seeds are below 2^63, the largest integer of a TOML file.
    table.push("seed", Column::Int(records.clone().map(|r| Some(r.seed as i64)).collect()));
    table.count("first_view", records.map(|r| r.first_view));
    table
}

fn step_identity(records: &[RunRecord]) -> Table {
    let mut table = identity(all_steps(records).map(|(record, ..)| record));
    table.count("step", all_steps(records).map(|(_, number, _)| number));
    table
}

/// Every step of every run, with its number from 1 on.
fn all_steps(records: &[RunRecord]) -> impl Iterator<Item = (&RunRecord, usize, &StepMeasures)> + Clone {
    let with_measures = records.iter().filter_map(|record| Some((record, record.measures()?)));
    with_measures
        .flat_map(|(record, m)| m.steps.iter().zip(1..).map(move |(step, number)| (record, number, step)))
}

/// Number of views until this share of the reachable object voxels was seen.
fn views_to(measures: &Measures, share: f64) -> Option<usize> {
    let is_reached = |step: &StepMeasures| step.seen.is_some_and(|seen| seen >= share);
    measures.steps.iter().position(is_reached).map(|i| i + 1)
}

/// A column for every value that is set in any configuration, named by its path.
fn configurations(table: &mut Table, records: &[RunRecord]) -> Result<(), Failure> {
    let rows = records.iter().map(|record| flat(&record.config)).collect::<Result<Vec<_>, _>>()?;
    let mut columns: BTreeMap<&str, Vec<Option<&Value>>> = BTreeMap::new();
    for (i, row) in rows.iter().enumerate() {
        for (path, value) in row {
            columns.entry(path).or_insert_with(|| vec![None; rows.len()])[i] = Some(value);
        }
    }
    for (path, values) in columns {
        table.push(format!("config.{path}"), typed(&values));
    }
    Ok(())
}

/// The values of a configuration by their dotted paths.
fn flat(config: &ScanConfig) -> Result<BTreeMap<String, Value>, Failure> {
    fn walk(prefix: &str, table: toml::Table, values: &mut BTreeMap<String, Value>) {
        for (key, value) in table {
            match value {
                Value::Table(table) => walk(&format!("{prefix}{key}."), table, values),
                value => drop(values.insert(format!("{prefix}{key}"), value)),
            }
        }
    }
    let mut values = BTreeMap::new();
    walk("", toml::Table::try_from(config).map_err(Failure::data)?, &mut values);
    Ok(values)
}

/// A column of the type that all values have, or else of texts.
fn typed(values: &[Option<&Value>]) -> Column {
    let all = |is: fn(&Value) -> bool| values.iter().flatten().all(|value| is(value));
    let each = || values.iter().copied();
    if all(Value::is_bool) {
        Column::Bool(each().map(|value| value?.as_bool()).collect())
    } else if all(Value::is_integer) {
        Column::Int(each().map(|value| value?.as_integer()).collect())
    } else if all(Value::is_float) {
        Column::Float(each().map(|value| value?.as_float()).collect())
    } else {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        Column::Text(each().map(|value| value.map(text)).collect())
    }
}

/// The name that serde gives a value.
fn name_of(value: &impl Serialize) -> Result<String, Failure> {
    let value = Value::try_from(value).map_err(Failure::data)?;
    Ok(value.as_str().unwrap_or_default().to_owned())
}

impl RunRecord {
    /// What was measured, if the run was done.
    fn measures(&self) -> Option<&Measures> {
        match &self.result {
            RunResult::Done(measures) => Some(measures),
            RunResult::Failed(_) => None,
        }
    }

    /// Why it failed, if it did.
    pub(super) fn failure(&self) -> Option<&str> {
        match &self.result {
            RunResult::Done(_) => None,
            RunResult::Failed(reason) => Some(reason),
        }
    }
}
