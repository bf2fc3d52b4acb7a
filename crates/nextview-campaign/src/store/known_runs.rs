use super::StoredRecord;
use super::difference::difference;
use crate::{RunId, RunRecord};
use nextview_scan::Fault;
use std::collections::BTreeMap;

/// The records of a file so far, of each run one.
#[derive(Debug, Default)]
pub(super) struct KnownRuns {
    by_id: BTreeMap<RunId, StoredRecord>,
}

impl KnownRuns {
    /// Adds a record; one that equals an earlier one of the same run changes nothing. Fails if they differ.
    pub fn add(&mut self, stored: StoredRecord) -> Result<(), Fault> {
        let id = stored.record.id();
        if let Some(known) = self.by_id.get(&id) {
            return conflict(&known.record, &stored.record).map_or(Ok(()), |difference| {
                let lines = format!("lines {} and {}", known.line, stored.line);
                Err(Fault::data(format!("{lines} have unequal records of one run, {id}: {difference}")))
            });
        }
        self.by_id.insert(id, stored);
        Ok(())
    }

    /// The records in the order of their runs' identities.
    pub fn into_records(self) -> impl Iterator<Item = RunRecord> {
        self.by_id.into_values().map(|stored| stored.record)
    }
}

/// Why two records of a run are not equal; times, memory and host aside.
pub(super) fn conflict(first: &RunRecord, second: &RunRecord) -> Option<String> {
    if first.build != second.build {
        return Some(format!("by the builds {} and {}", first.build, second.build));
    }
    if first.data_set != second.data_set {
        return Some(format!("of the data sets {} and {}", first.data_set, second.data_set));
    }
    let [a, b] = [first, second].map(|record| toml::Table::try_from(&record.config).unwrap_or_default());
    if let Some(difference) = difference(&a, &b) {
        return Some(format!("{} is {} and {}", difference.key, difference.first, difference.second));
    }
    (!first.has_same_results(second)).then(|| "their results differ".to_owned())
}
