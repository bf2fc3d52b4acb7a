//! The planners and parameters of a specification.

use crate::Failure;
use crate::scan::{ScanConfig, merged};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// One planner with its parameters, or several by a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VariantSpec {
    /// With `{path}` for values of the configuration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// In place of the specification's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<Vec<u64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_views: Option<Vec<usize>>,
    /// Keys of [`ScanConfig`], over the specification's.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    pub scan: Table,
    /// Lists of values for keys of [`ScanConfig`], over both.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    pub sweep: Table,
}

/// A planner with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variant {
    pub label: String,
    /// Object, seed and first view aside.
    pub config: ScanConfig,
    pub seeds: Vec<u64>,
    pub first_views: Vec<usize>,
}

/// Keys that are not for a variant to decide, and what does.
const DECIDED_ELSEWHERE: [(&str, &str); 3] =
    [("object", "objects"), ("seed", "seeds"), ("first_view", "first_views")];

impl VariantSpec {
    /// All combinations of the swept values, the last key changing fastest; with the specification's keys, seeds and first
    /// views where it has none of its own.
    pub fn expand(
        &self,
        scan: &Table,
        seeds: &[u64],
        first_views: &[usize],
    ) -> Result<Vec<Variant>, Failure> {
        let seeds = self.seeds.clone().unwrap_or_else(|| seeds.to_vec());
        let first_views = self.first_views.clone().unwrap_or_else(|| first_views.to_vec());
        check_distinct("seeds", &seeds)?;
        check_distinct("first_views", &first_views)?;
        let sweeps = sweeps(&self.sweep, "")?;
        let mut tables = vec![merged(scan.clone(), self.scan.clone())];
        for (path, values) in &sweeps {
            let with = |table: &Table, value: &Value| merged(table.clone(), nested(path, value.clone()));
            tables = tables.iter().flat_map(|table| values.iter().map(|value| with(table, value))).collect();
        }
        let template = self.label.clone().unwrap_or_else(|| default_label(&sweeps));
        let variant = |table: Table| {
            let config = load(table)?;
            config.check_stop()?;
            let label = filled(&template, &config)?;
            let (seeds, first_views) = (seeds.clone(), first_views.clone());
            first_views.iter().try_for_each(|&view| check_first_view(&config, view))?;
            Ok(Variant { label, config, seeds, first_views })
        };
        tables.into_iter().map(variant).collect()
    }
}

/// Fails unless there is at least one value and none twice.
pub(super) fn check_distinct<T: PartialEq + std::fmt::Debug>(
    field: &str,
    values: &[T],
) -> Result<(), Failure> {
    if values.is_empty() {
        return Err(Failure::data(format!("{field} is empty, expected at least one value")));
    }
    let twice = (1..values.len()).find(|&i| values[..i].contains(&values[i]));
    twice.map_or(Ok(()), |i| Err(Failure::data(format!("{field} has {:?} twice", values[i]))))
}

/// The configuration; unless it says otherwise, all its seeds share their candidates.
fn load(mut table: Table) -> Result<ScanConfig, Failure> {
    if let Some((key, by)) = DECIDED_ELSEWHERE.iter().find(|(key, _)| table.contains_key(*key)) {
        return Err(Failure::data(format!(
            "`{key}` is not for [scan], `scan` or `sweep`: `{by}` decides it"
        )));
    }
    if table.contains_key("recording") {
        return Err(Failure::data(
            "`recording` is for `nextview scan` alone: a campaign simulates its objects",
        ));
    }
    table.entry("view_seed").or_insert(Value::Integer(0));
    ScanConfig::from_table(table)
}

/// Where a rule makes the candidates, their number is known before the run.
fn check_first_view(config: &ScanConfig, first_view: usize) -> Result<(), Failure> {
    if config.view_space.rule().is_none() {
        return Ok(());
    }
    let n = config.candidates;
    if first_view >= n {
        return Err(Failure::data(format!("first view {first_view} is none of the {n} candidates")));
    }
    if config.views == 0 || config.views > n {
        let views = config.views;
        return Err(Failure::data(format!("views is {views}, expected 1 to {n} (the candidates)")));
    }
    Ok(())
}

/// The swept keys and their values, in the order of the keys.
fn sweeps(table: &Table, prefix: &str) -> Result<Vec<(String, Vec<Value>)>, Failure> {
    let sweep = |(key, value): (&String, &Value)| {
        let path = format!("{prefix}{key}");
        match value {
            Value::Table(table) => sweeps(table, &format!("{path}.")),
            Value::Array(values) => {
                check_distinct(&format!("sweep.{path}"), values)?;
                Ok(vec![(path, values.clone())])
            }
            value => Err(Failure::data(format!("sweep.{path} is {value}, expected a list of values"))),
        }
    };
    Ok(table.iter().map(sweep).collect::<Result<Vec<_>, _>>()?.concat())
}

/// The table in which the dotted path leads to the value.
fn nested(path: &str, value: Value) -> Table {
    match path.split_once('.') {
        Some((key, rest)) => Table::from_iter([(key.to_owned(), Value::Table(nested(rest, value)))]),
        None => Table::from_iter([(path.to_owned(), value)]),
    }
}

/// The planner's name and the swept values.
fn default_label(sweeps: &[(String, Vec<Value>)]) -> String {
    let paths = sweeps.iter().map(|(path, _)| path).filter(|path| *path != "planner");
    let values = paths.map(|path| format!(", {} {{{path}}}", path.rsplit('.').next().unwrap_or(path)));
    format!("{{planner}}{}", values.collect::<String>())
}

/// The template with values of the configuration in place of `{path}`.
fn filled(template: &str, config: &ScanConfig) -> Result<String, Failure> {
    let config = Table::try_from(config).map_err(Failure::data)?;
    let (mut label, mut left) = (String::new(), template);
    while let Some((before, after)) = left.split_once('{') {
        let (path, rest) = after
            .split_once('}')
            .ok_or_else(|| Failure::data(format!("label {template:?}: a '{{' without '}}'")))?;
        let value = at(&config, path).ok_or_else(|| {
            Failure::data(format!("label {template:?}: {{{path}}} is no value that is set"))
        })?;
        label += before;
        label += &value;
        left = rest;
    }
    Ok(label + left)
}

/// The value at a dotted path, as text; none where there is none or a table.
fn at(table: &Table, path: &str) -> Option<String> {
    let (key, rest) = path.split_once('.').map_or((path, None), |(key, rest)| (key, Some(rest)));
    match (table.get(key)?, rest) {
        (Value::Table(table), Some(rest)) => at(table, rest),
        (Value::Table(_), None) | (_, Some(_)) => None,
        (Value::String(text), None) => Some(text.clone()),
        (Value::Float(number), None) => Some(number.to_string()),
        (value, None) => Some(value.to_string()),
    }
}
