use super::FaultList;
use nextview_scan::{Fault, ScanConfig, read_value};
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// A table of a specification, read key by key so that everything that is wrong in it is found at once.
pub(super) struct Section<'a> {
    /// Dotted key of the table with a dot behind it; empty at the top.
    prefix: String,
    /// How messages name the table; empty at the top.
    name: String,
    left: Table,
    known: Vec<&'static str>,
    faults: &'a mut FaultList,
}

impl<'a> Section<'a> {
    /// The whole specification.
    pub fn top(table: Table, faults: &'a mut FaultList) -> Self {
        Self { prefix: String::new(), name: String::new(), left: table, known: Vec::new(), faults }
    }

    /// A table in a list: the entry of this index, which messages give this name.
    pub fn entry(list: &str, index: usize, name: String, table: Table, faults: &'a mut FaultList) -> Self {
        Self { prefix: format!("{list}.{index}."), name, ..Self::top(table, faults) }
    }

    /// The value of the key; none if it is not set or not of its type, which is a fault.
    pub fn take<T: DeserializeOwned>(&mut self, key: &'static str) -> Option<T> {
        self.known.push(key);
        let value = self.left.remove(key)?;
        let whole_key = format!("{}{key}", self.prefix);
        read_value(&whole_key, &value).map_err(|fault| self.add_at(fault)).ok()
    }

    /// The same of a list of values, each of which may be wrong by itself.
    pub fn take_list(&mut self, key: &'static str) -> Vec<Value> {
        self.take(key).unwrap_or_default()
    }

    /// Whether the key is set.
    pub fn has(&self, key: &str) -> bool {
        self.left.contains_key(key)
    }

    /// Adds a fault of the value of this key.
    pub fn fault(&mut self, key: &str, problem: &str) {
        let fault = Fault::data(format!("`{}{key}`: {problem}", self.prefix));
        self.add(key, fault);
    }

    /// Keys that were not asked for are faults.
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
