use super::FaultList;
use nextview_scan::{Fault, ScanConfig, read_value};
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// A table of a specification, read key by key to find all its faults at once.
pub(super) struct Section<'a> {
    /// Dotted key of the table with a trailing dot; empty for the whole specification.
    prefix: String,
    /// Name of the table in messages; empty for the whole specification.
    name: String,
    left: Table,
    known: Vec<&'static str>,
    faults: &'a mut FaultList,
}

impl<'a> Section<'a> {
    /// Creates the section of the whole specification.
    pub fn top(table: Table, faults: &'a mut FaultList) -> Self {
        Self { prefix: String::new(), name: String::new(), left: table, known: Vec::new(), faults }
    }

    /// Creates the section of a table in a list: the entry with this index, called by this name in messages.
    pub fn entry(list: &str, index: usize, name: String, table: Table, faults: &'a mut FaultList) -> Self {
        Self { prefix: format!("{list}.{index}."), name, ..Self::top(table, faults) }
    }

    /// Takes the value of the key; `None` if it is not set, or has the wrong type, which is a fault.
    pub fn take<T: DeserializeOwned>(&mut self, key: &'static str) -> Option<T> {
        self.known.push(key);
        let value = self.left.remove(key)?;
        let whole_key = format!("{}{key}", self.prefix);
        read_value(&whole_key, &value).map_err(|fault| self.add_at(fault)).ok()
    }

    /// Takes a list of values, each of which may be invalid by itself.
    pub fn take_list(&mut self, key: &'static str) -> Vec<Value> {
        self.take(key).unwrap_or_default()
    }

    /// Returns whether the key is set.
    pub fn has(&self, key: &str) -> bool {
        self.left.contains_key(key)
    }

    /// Adds a fault of the value of this key.
    pub fn fault(&mut self, key: &str, problem: &str) {
        let fault = Fault::data(format!("`{}{key}`: {problem}", self.prefix));
        self.add(key, fault);
    }

    /// Reports unknown keys as faults.
    pub fn end(mut self) {
        for (key, _) in std::mem::take(&mut self.left) {
            let fault = Fault::unknown_key(&self.prefix, &key, self.known.iter().copied());
            let has_scan = self.known.contains(&"scan");
            let is_of_scan = has_scan && ScanConfig::has_key(&key);
            let remedy = format!("in a campaign, it is `{}scan.{key}`", self.prefix);
            self.add(&key, if is_of_scan { fault.with_remedy(remedy) } else { fault });
        }
    }

    fn add(&mut self, key: &str, fault: Fault) {
        self.add_at(Fault { key: Some(format!("{}{key}", self.prefix)), ..fault });
    }

    /// Adds a fault that has its key.
    fn add_at(&mut self, fault: Fault) {
        let key = fault.key.clone().unwrap_or_default();
        let fault = if self.name.is_empty() { fault } else { fault.within(&self.name) };
        self.faults.add(&key, fault);
    }
}
