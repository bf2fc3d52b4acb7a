//! Values between Python and the library: configurations in, records out.

use crate::errors::{exception, input_error, internal_error};
use crate::planner;
use crate::pose::pose_of;
use crate::view::View;
use nextview::sensor::Sensor;
use nextview_scan::{Fault, FaultKind, Faults, Named, PlannerName, ScanConfig, files};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple, PyType};
use serde::Serialize;
use std::path::PathBuf;
use toml::{Table, Value};

/// A record as Python's dicts, lists, texts and numbers.
pub fn to_python<'py>(py: Python<'py>, record: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(record).map_err(|error| internal_error(py, &error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// The configuration of a dict.
pub fn config(dict: &Bound<'_, PyDict>) -> PyResult<ScanConfig> {
    ScanConfig::from_table(table(dict)?).map_err(|faults| of_request(dict.py(), faults))
}

/// The exception of faults in values: those that are in no file are the caller's.
pub fn of_request(py: Python<'_>, faults: Faults) -> PyErr {
    let kind = |fault: &Fault| if fault.place.is_none() { FaultKind::Request } else { fault.kind };
    exception(py, faults.map(|fault| Fault { kind: kind(&fault), ..fault }))
}

/// The table of a dict; entries that are None count as left out.
pub fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict.iter().filter(|(_, value)| !value.is_none()) {
        let name = key.cast::<PyString>().map_err(|_| {
            input_error(dict.py(), format!("a key of the configuration is {key}, expected a text"))
        })?;
        let name = name.to_str()?.to_owned();
        let value = value_of(&name, &value, 0)?;
        table.insert(name, value);
    }
    Ok(table)
}

/// Depth of values within values that a configuration may have: ten times what it needs.
const MOST_NESTED: usize = 40;

fn value_of(name: &str, value: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
    let py = value.py();
    if depth > MOST_NESTED {
        return Err(input_error(py, format!("`{name}` is nested too deeply")));
    }
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(value.is_true()));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_str()?.to_owned()));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(Value::Table(table(dict)?));
    }
    let is_matrix = value.cast::<PyUntypedArray>().is_ok_and(|array| array.ndim() == 2);
    if is_matrix || value.is_instance_of::<View>() {
        let pose = pose_of(name, value)?;
        return Value::try_from(pose).map_err(|error| internal_error(py, &error.to_string()));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.map(|item| value_of(name, &item?, depth + 1));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    if name == "planner"
        && let Ok(class) = value.cast::<PyType>()
    {
        return Ok(Value::String(planner::name_of(class)?));
    }
    number(name, value)
}

/// A number of Python or numpy, or a path.
fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let py = value.py();
    let is_int = value.is_instance_of::<PyInt>() || value.hasattr("__index__")?;
    if is_int && let Ok(int) = value.extract::<i64>() {
        return Ok(Value::Integer(int));
    }
    let is_float = value.is_instance_of::<PyFloat>() || (value.hasattr("__float__")? && !is_int);
    if is_float && let Ok(float) = value.extract::<f64>() {
        return Ok(Value::Float(float));
    }
    if value.hasattr("__fspath__")? {
        let text: String = value.call_method0("__fspath__")?.extract()?;
        return Ok(Value::String(text));
    }
    let kind = value.get_type().name()?;
    if name == "planner" {
        let expected = "expected a name, or a class: a subclass of nextview.Planner or nextview.Gain";
        return Err(input_error(
            py,
            format!("`planner` is of type {kind}, {expected}; pass the class itself"),
        ));
    }
    let expected = "expected a text, a truth value, a number of 64 bits, a list or a dict";
    Err(input_error(py, format!("`{name}` is of type {kind}, or out of range: {expected}")))
}

/// The configuration in a file.
#[pyfunction]
pub fn read_config(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let text = files::read_text(&path, MAX_CONFIG_BYTES).map_err(|fault| exception(py, fault))?;
    let config = ScanConfig::parse(&text, Some(&path), None).map_err(|faults| exception(py, faults))?;
    to_python(py, &config)
}

/// Size of a file beyond which it is no configuration.
const MAX_CONFIG_BYTES: u64 = 1 << 20;

/// Names of the planners with a line about each.
#[pyfunction]
pub fn planners() -> Vec<(&'static str, &'static str)> {
    PlannerName::ALL.iter().map(|planner| (planner.name(), planner.about())).collect()
}

/// Names of the sensors.
#[pyfunction]
pub fn sensors() -> Vec<&'static str> {
    Sensor::ALL.iter().map(|sensor| sensor.name()).collect()
}

/// Names of the built-in objects.
#[pyfunction]
pub fn builtin_objects() -> Vec<String> {
    nextview_sim::builtin::names().map(|name| format!("builtin:{name}")).collect()
}
