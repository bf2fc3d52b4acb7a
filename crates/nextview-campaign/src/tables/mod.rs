//! The tables of a campaign: a row per run, a row per view, and the times of these views.

mod columns;
mod config;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;
mod table;

pub use rows::{runs, steps, times};
pub use table::{Column, Table};

use crate::RunRecord;
use nextview_scan::Fault;
use nextview_scan::files::{self, Overwrite};
use std::path::Path;

/// The files that [`write()`] makes.
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

/// Writes `runs`, `steps` and `times` into a folder as `.csv` and, with the feature `parquet`, as `.parquet`,
/// in place of those that are there.
///
/// Equal campaigns give equal files of runs and steps, and rows in the order of the records.
pub fn write(dir: &Path, records: &[&RunRecord]) -> Result<(), Fault> {
    let rule = Overwrite::results();
    for (name, table) in [("runs", runs(records)?), ("steps", steps(records)?), ("times", times(records))] {
        files::write(&dir.join(format!("{name}.csv")), &rule, |w| table.write_csv(w))?;
        #[cfg(feature = "parquet")]
        files::write(&dir.join(format!("{name}.parquet")), &rule, |w| table.write_parquet(w))?;
    }
    Ok(())
}
