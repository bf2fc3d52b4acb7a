use super::difference::difference;
use super::records::{Position, StoredRecord};
use super::run_records::read_at;
use crate::RunRecord;
use nextview_scan::Fault;
use std::path::PathBuf;

/// Fails if a record differs from an earlier one of the same run.
pub(super) fn check_repeated(
    files: &[PathBuf],
    known: Position,
    repeated: &StoredRecord,
) -> Result<(), Fault> {
    let Some(difference) = conflict(&read_at(files, known)?, &repeated.record) else { return Ok(()) };
    let (first, second) = (known.line, repeated.line);
    let lines = match known.file == repeated.position.file {
        true => format!("lines {first} and {second}"),
        false => format!("line {first} of {} and line {second}", files[known.file as usize].display()),
    };
    let id = repeated.record.id();
    Err(Fault::data(format!("{lines} have different records of the same run, {id}: {difference}")))
}

/// The difference between two records of a run, ignoring times, memory and host.
pub(super) fn conflict(first: &RunRecord, second: &RunRecord) -> Option<String> {
    if first.build != second.build {
        return Some(format!("they are from the builds {} and {}", first.build, second.build));
    }
    if first.data_set != second.data_set {
        return Some(format!("they are from the data sets {} and {}", first.data_set, second.data_set));
    }
    let [a, b] = [first, second].map(|record| toml::Table::try_from(&record.config).unwrap_or_default());
    if let Some(difference) = difference(&a, &b) {
        return Some(format!("{} is {} and {}", difference.key, difference.first, difference.second));
    }
    (!first.has_same_results(second)).then(|| "their results differ".to_owned())
}
