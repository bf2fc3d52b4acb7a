//! YAML as configuration values.

use saphyr::{LoadableYamlNode, Scalar, Yaml};
use toml::Value;

/// Parses the documents of a YAML text, or describes the fault.
pub fn documents(text: &str) -> Result<Vec<Yaml<'_>>, String> {
    Yaml::load_from_str(text).map_err(|error| format!("is not valid YAML: {error}"))
}

/// Parses the value of a parameter after `:=`.
pub fn parse(text: &str) -> Result<Value, String> {
    match documents(text)?.first() {
        Some(yaml) => value(yaml),
        None => Ok(Value::String(String::new())),
    }
}

/// Converts the value of a parameter: a scalar or a list of them.
pub fn value(yaml: &Yaml<'_>) -> Result<Value, String> {
    match yaml {
        Yaml::Value(Scalar::Boolean(value)) => Ok(Value::Boolean(*value)),
        Yaml::Value(Scalar::Integer(value)) => Ok(Value::Integer(*value)),
        Yaml::Value(Scalar::FloatingPoint(value)) => Ok(Value::Float(value.into_inner())),
        Yaml::Value(Scalar::String(value)) => Ok(Value::String(value.to_string())),
        Yaml::Sequence(items) => Ok(Value::Array(items.iter().map(value).collect::<Result<_, _>>()?)),
        _ => Err("is not a value, expected a number, true or false, a string, or a list of them".to_owned()),
    }
}
