//! The folder of a campaign: its specification, and `runs.jsonl`, which only this module reads and writes.
//!
//! A line of `runs.jsonl` is a [`RunRecord`](crate::RunRecord), written and synced when the run is done. The
//! rules:
//!
//! - One process writes at a time: it holds a lock on the file, which ends with the process.
//! - A last line without a line feed is an incomplete write. Readers leave it out and report it; resuming
//!   cuts it.
//! - Any other line that is not a record is a fault, with line and column.
//! - Records of one run that are equal, ignoring times, memory and host, count once; unequal ones are a fault
//!   that names both lines.
//! - Resuming requires every record to be of the same build, of a run of the specification, and with the
//!   configuration that this build gives that run. Reading does not.
//!
//! [`records`] returns the lines of a file one after the other, [`read`] each run once; [`Store`] writes, and
//! [`merge()`] merges the folders of a campaign's shards. None of them holds all records in memory.

mod checks;
mod conflict;
mod difference;
mod folder;
mod merge;
mod records;
mod run_records;
mod staging;
#[expect(clippy::module_inception, reason = "the type that the module is about")]
mod store;
mod stored_runs;

pub use folder::{campaign_folder, shard_folder};
pub use merge::{Merged, merge};
pub use records::{Records, StoredRecord, records};
pub use run_records::RunRecords;
pub use store::Store;
pub use stored_runs::{StoredRuns, config_of_row, read};

/// Name of the file of records in a campaign's folder.
const RUNS: &str = "runs.jsonl";

#[cfg(test)]
mod tests;
