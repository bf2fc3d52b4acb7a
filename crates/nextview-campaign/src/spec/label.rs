use super::sweep::Sweep;
use nextview_scan::{Fault, ScanConfig};
use toml::{Table, Value};

/// A template with the planner's name and the swept values.
pub(super) fn default_label(sweeps: &[Sweep]) -> String {
    let keys = sweeps.iter().map(|sweep| &sweep.key).filter(|key| *key != "planner");
    let values = keys.map(|key| format!(", {} {{{key}}}", key.rsplit('.').next().unwrap_or(key)));
    format!("{{planner}}{}", values.collect::<String>())
}

/// Replaces `{key}` in the template with values of the configuration.
pub(super) fn filled(template: &str, config: &ScanConfig) -> Result<String, Fault> {
    let config = Table::try_from(config).map_err(Fault::data)?;
    let (mut label, mut left) = (String::new(), template);
    while let Some((before, after)) = left.split_once('{') {
        let (key, rest) = after
            .split_once('}')
            .ok_or_else(|| Fault::data(format!("label {template:?} has a '{{' without a '}}'")))?;
        let value = at(&config, key)
            .ok_or_else(|| Fault::data(format!("label {template:?}: {{{key}}} is not a key that is set")))?;
        label += before;
        label += &value;
        left = rest;
    }
    Ok(label + left)
}

/// The value of a dotted key, as text; `None` if it is missing or a table.
fn at(table: &Table, key: &str) -> Option<String> {
    let (key, rest) = key.split_once('.').map_or((key, None), |(key, rest)| (key, Some(rest)));
    match (table.get(key)?, rest) {
        (Value::Table(table), Some(rest)) => at(table, rest),
        (Value::Table(_), None) | (_, Some(_)) => None,
        (Value::String(text), None) => Some(text.clone()),
        (Value::Float(number), None) => Some(number.to_string()),
        (value, None) => Some(value.to_string()),
    }
}
