use super::{Column, Table};
use crate::RunRecord;
use nextview_scan::{Fault, ScanConfig};
use std::collections::BTreeMap;
use toml::Value;

/// A column `config.KEY` for every value that is set in any configuration.
pub(super) fn config_columns(table: &mut Table, records: &[&RunRecord]) -> Result<(), Fault> {
    let rows = records.iter().map(|record| flat(&record.config)).collect::<Result<Vec<_>, _>>()?;
    let mut columns: BTreeMap<&str, Vec<Option<&Value>>> = BTreeMap::new();
    for (row, i) in rows.iter().zip(0..) {
        for (key, value) in row {
            columns.entry(key).or_insert_with(|| vec![None; rows.len()])[i] = Some(value);
        }
    }
    for (key, values) in columns {
        table.push(format!("config.{key}"), typed(&values));
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
