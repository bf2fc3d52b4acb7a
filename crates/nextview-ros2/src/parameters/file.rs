//! Parameter files: `node: { ros__parameters: { name: value } }`.

use super::value::{documents, value};
use crate::names::Names;
use saphyr::Yaml;
use toml::Value;

/// Adds the parameters of a file for this node, in order: those below `/**`, below its name with namespace,
/// or below its bare name. Names of nested maps are joined by dots.
pub fn add(text: &str, names: &Names, parameters: &mut Vec<(String, Value)>) -> Result<(), String> {
    for document in &documents(text)? {
        let Some(nodes) = document.as_mapping() else {
            return Err("holds no map, expected the names of nodes with `ros__parameters` below".to_owned());
        };
        for (node, below) in nodes {
            let node = node.as_str().unwrap_or_default();
            let is_ours = node == "/**" || node == names.node || node == names.full();
            let given = below.as_mapping_get("ros__parameters");
            match given {
                Some(given) if is_ours => flatten("", given, parameters)?,
                None if is_ours => {
                    return Err(format!("'{node}' has no `ros__parameters`, expected them below its name"));
                }
                _ => (),
            }
        }
    }
    Ok(())
}

/// Deeper than the name of any parameter.
const MAX_DEPTH: usize = 16;

fn flatten(prefix: &str, yaml: &Yaml<'_>, parameters: &mut Vec<(String, Value)>) -> Result<(), String> {
    let Some(map) = yaml.as_mapping() else {
        let value = value(yaml).map_err(|problem| format!("the parameter `{prefix}` {problem}"))?;
        parameters.push((prefix.to_owned(), value));
        return Ok(());
    };
    for (name, inner) in map {
        let Some(name) = name.as_str() else {
            return Err(format!("a name below '{prefix}' is not a string, expected names of parameters"));
        };
        let name = if prefix.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") };
        if name.split('.').count() > MAX_DEPTH {
            return Err(format!("'{name}' has more than {MAX_DEPTH} parts, expected fewer"));
        }
        flatten(&name, inner, parameters)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<Vec<(String, Value)>, String> {
        let mut parameters = Vec::new();
        add(text, &Names::default(), &mut parameters).map(|()| parameters)
    }

    #[test]
    fn the_nodes_own_parameters_are_found() {
        let text = "\
/**:
  ros__parameters: { views: 3, live: { box_m: [0, 0, 0, 1.5, 1, 1] } }
other:
  ros__parameters: { views: 4 }
/nextview:
  ros__parameters:
    global_frame: map
    sensor_model.max_range: 2.5
    auto_capture: true
";
        let found: Vec<String> =
            read(text).unwrap().iter().map(|(name, value)| format!("{name}={value}")).collect();
        assert_eq!(
            found,
            [
                "views=3",
                "live.box_m=[0, 0, 0, 1.5, 1, 1]",
                "global_frame=\"map\"",
                "sensor_model.max_range=2.5",
                "auto_capture=true"
            ]
        );
    }

    #[test]
    fn faults_are_told() {
        for (text, expected) in [
            ("[1, 2]", "holds no map"),
            ("nextview: 3", "has no `ros__parameters`"),
            ("nextview: { ros__parameters: { a: ~ } }", "`a` is not a value"),
            ("nextview: { ros__parameters: { 3: 4 } }", "is not a string"),
            ("a: [", "is not valid YAML"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    proptest! {
        #[test]
        fn never_panics(text in "[a-z/*:{}\\[\\], \n0-9.~&'\"-]{0,80}") {
            let _ = read(&text);
            let _ = read(&format!("nextview: {{ ros__parameters: {text} }}"));
            let _ = super::super::value::parse(&text);
        }
    }
}
