//! The tables of a campaign: a row per run, a row per view, and the times of these views.

mod columns;
mod config;
mod files;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;
mod table;

pub use rows::{runs, steps, times};
pub use table::{Column, Table};

use crate::RunRecord;
use crate::store::RunRecords;
use config::ConfigKeys;
use files::TableFiles;
use nextview_scan::Fault;
use std::path::Path;

/// The files written by [`write()`].
pub const FILES: &[&str] = &[
    "runs.csv",
    "steps.csv",
    "times.csv",
    #[cfg(feature = "parquet")]
    "runs.parquet",
    #[cfg(feature = "parquet")]
    "steps.parquet",
    #[cfg(feature = "parquet")]
    "times.parquet",
];

/// Number of runs whose rows are held in memory at a time; they form a row group of Parquet.
const GROUP: usize = 2048;

/// Writes `runs`, `steps` and `times` into a folder as `.csv` and, with the feature `parquet`, as `.parquet`,
/// replacing existing files.
///
/// Equal campaigns give equal files of runs and steps, with rows in the order of the records.
pub fn write(dir: &Path, records: &RunRecords) -> Result<(), Fault> {
    let mut keys = ConfigKeys::default();
    records.configs().try_for_each(|config| keys.add(&config?))?;
    let mut files = None;
    let mut group = Vec::new();
    let mut records = records.iter();
    loop {
        group.clear();
        for record in records.by_ref().take(GROUP) {
            group.push(record?);
        }
        let rows: Vec<&RunRecord> = group.iter().collect();
        let tables = [rows::runs_with(&keys, &rows)?, steps(&rows)?, times(&rows)];
        let files = match &mut files {
            None => files.insert(TableFiles::begin(dir, &tables)?),
            Some(_) if group.is_empty() => break,
            Some(files) => files,
        };
        files.add(&tables)?;
    }
    files.map_or(Ok(()), TableFiles::publish)
}
