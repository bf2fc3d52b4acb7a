use super::values::check_distinct;
use nextview_scan::{Fault, merged, nested};
use toml::{Table, Value};

/// A key of the configuration and its sequence of values.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    /// Dotted key.
    pub key: String,
    pub values: Vec<Value>,
}

/// The sweeps of a table in the order of their keys, and the faults by key.
pub(super) fn of(table: &Table) -> (Vec<Sweep>, Vec<(String, Fault)>) {
    let (mut sweeps, mut faults) = (Vec::new(), Vec::new());
    collect("", table, &mut sweeps, &mut faults);
    (sweeps, faults)
}

fn collect(prefix: &str, table: &Table, sweeps: &mut Vec<Sweep>, faults: &mut Vec<(String, Fault)>) {
    for (key, value) in table {
        let key = format!("{prefix}{key}");
        match value {
            Value::Table(table) => collect(&format!("{key}."), table, sweeps, faults),
            Value::Array(values) => match check_distinct(&format!("sweep.{key}"), values) {
                Ok(()) => sweeps.push(Sweep { key, values: values.clone() }),
                Err(fault) => faults.push((key, fault)),
            },
            value => {
                let message = format!("sweep.{key} is {value}, expected a list of values");
                faults.push((key, Fault::data(message)));
            }
        }
    }
}

/// The number of combinations of the swept values; [`usize::MAX`] if it overflows.
pub(super) fn n_combinations(sweeps: &[Sweep]) -> usize {
    sweeps.iter().fold(1, |n, sweep| n.saturating_mul(sweep.values.len()))
}

/// The factors of that number, such as `max_flow.gamma 3 x candidates 2`.
pub(super) fn factors(sweeps: &[Sweep]) -> String {
    let factors = sweeps.iter().map(|Sweep { key, values }| format!("{key} {}", values.len()));
    factors.collect::<Vec<_>>().join(" x ")
}

/// The table with every combination of the swept values, the last key changing fastest.
pub(super) fn combined(table: Table, sweeps: &[Sweep]) -> Vec<Table> {
    sweeps.iter().fold(vec![table], |tables, Sweep { key, values }| {
        let with = |table: &Table, value: &Value| merged(table.clone(), nested(key, value.clone()));
        tables.iter().flat_map(|table| values.iter().map(move |value| with(table, value))).collect()
    })
}
