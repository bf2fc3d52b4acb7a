use std::collections::BTreeSet;
use toml::{Table, Value};

/// A value that differs between two tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Difference {
    /// Dotted key.
    pub key: String,
    /// The value in the first table, as text.
    pub first: String,
    /// The value in the second table, as text.
    pub second: String,
}

/// The first difference between two tables in the order of their keys.
pub(super) fn difference(first: &Table, second: &Table) -> Option<Difference> {
    below("", first, second)
}

fn below(prefix: &str, first: &Table, second: &Table) -> Option<Difference> {
    let keys: BTreeSet<&String> = first.keys().chain(second.keys()).collect();
    keys.into_iter().find_map(|name| {
        let key = format!("{prefix}{name}");
        match (first.get(name), second.get(name)) {
            (first, second) if first == second => None,
            (Some(Value::Table(first)), Some(Value::Table(second))) => {
                below(&format!("{key}."), first, second)
            }
            (first, second) => Some(Difference { key, first: text(first), second: text(second) }),
        }
    })
}

fn text(value: Option<&Value>) -> String {
    value.map_or_else(|| "not set".to_owned(), Value::to_string)
}
