use super::{Column, Table};
use crate::RunRecord;
use nextview_scan::{Fault, ScanConfig};
use rayon::prelude::*;
use std::collections::BTreeMap;
use toml::Value;

/// The values set in any configuration, by their dotted keys, with the common type of each.
#[derive(Clone, Debug, Default)]
pub(super) struct ConfigKeys(BTreeMap<String, KeyType>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KeyType {
    Bool,
    Int,
    Float,
    /// Texts, or values of several types.
    Text,
}

impl ConfigKeys {
    /// Adds the values of a configuration.
    pub fn add(&mut self, config: &ScanConfig) -> Result<(), Fault> {
        for (key, value) in flat(config)? {
            let kind = KeyType::of(&value);
            match self.0.get_mut(&key) {
                Some(known) if *known != kind => *known = KeyType::Text,
                Some(_) => (),
                None => drop(self.0.insert(key, kind)),
            }
        }
        Ok(())
    }
}

/// A column `config.KEY` per key.
pub(super) fn config_columns(
    table: &mut Table,
    keys: &ConfigKeys,
    records: &[&RunRecord],
) -> Result<(), Fault> {
    let mut rows = records.par_iter().map(|record| flat(&record.config)).collect::<Result<Vec<_>, _>>()?;
    for (key, kind) in &keys.0 {
        let values = rows.iter_mut().map(|row| row.remove(key)).collect();
        table.push(format!("config.{key}"), kind.column(values));
    }
    Ok(())
}

/// The values of a configuration by their dotted keys.
fn flat(config: &ScanConfig) -> Result<BTreeMap<String, Value>, Fault> {
    let mut values = BTreeMap::new();
    walk("", toml::Table::try_from(config).map_err(Fault::data)?, &mut values);
    Ok(values)
}

fn walk(prefix: &str, table: toml::Table, values: &mut BTreeMap<String, Value>) {
    for (key, value) in table {
        match value {
            Value::Table(table) => walk(&format!("{prefix}{key}."), table, values),
            value => drop(values.insert(format!("{prefix}{key}"), value)),
        }
    }
}

impl KeyType {
    fn of(value: &Value) -> Self {
        match value {
            Value::Boolean(_) => Self::Bool,
            Value::Integer(_) => Self::Int,
            Value::Float(_) => Self::Float,
            _ => Self::Text,
        }
    }

    fn column(self, values: Vec<Option<Value>>) -> Column {
        let each = || values.iter().map(Option::as_ref);
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        match self {
            Self::Bool => Column::Bool(each().map(|value| value?.as_bool()).collect()),
            Self::Int => Column::Int(each().map(|value| value?.as_integer()).collect()),
            Self::Float => Column::Float(each().map(|value| value?.as_float()).collect()),
            Self::Text => Column::Text(each().map(|value| value.map(text)).collect()),
        }
    }
}
