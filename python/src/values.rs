//! Configurations from Python values.

use crate::errors::{exception, input_error, internal_error};
use crate::planner_class;
use crate::records::to_python;
use crate::shown::{shown, type_of};
use crate::view::{View, pose_of};
use crate::watch::{compute, guarded};
use nextview::Cancel;
use nextview::sensor::Sensor;
use nextview_scan::{Fault, FaultKind, Faults, Named, PlannerName, ScanConfig, files};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple, PyType};
use std::path::PathBuf;
use toml::{Table, Value};

/// Reads the configuration in a dict.
pub fn config(dict: &Bound<'_, PyDict>) -> PyResult<ScanConfig> {
    let (py, table) = (dict.py(), table(dict)?);
    guarded(py, || ScanConfig::from_table(table))?.map_err(|faults| of_request(py, faults))
}

/// The exception for faults in values: a fault that is not in a file is one of the request.
pub fn of_request(py: Python<'_>, faults: Faults) -> PyErr {
    let kind = |fault: &Fault| if fault.place.is_none() { FaultKind::Request } else { fault.kind };
    exception(py, faults.map(|fault| Fault { kind: kind(&fault), ..fault }))
}

/// Converts a dict to a table; entries that are None count as missing.
pub fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    Conversion::default().table("", dict, 0)
}

/// The numbers of a list, of lists of equal length, or of a numpy array, with a matching shape.
pub fn numbers(
    name: &str,
    value: &Bound<'_, PyAny>,
    fits: impl Fn(&[usize]) -> bool,
    expected: &str,
) -> PyResult<Vec<f64>> {
    let py = value.py();
    let check = |shape: &[usize]| match fits(shape) {
        true => Ok(()),
        false => Err(input_error(py, format!("`{name}` has the shape {shape:?}, expected {expected}"))),
    };
    let wrong = || input_error(py, format!("`{name}` is {}, expected {expected}", shown(value)));
    let listed = match value.cast::<PyUntypedArray>() {
        Ok(array) => {
            check(array.shape())?;
            // By numpy's own method, whatever a subclass defines.
            py.get_type::<PyUntypedArray>().call_method1("tolist", (array,))?
        }
        Err(_) if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() => value.clone(),
        Err(_) => return Err(wrong()),
    };
    let mut numbers = Vec::new();
    let values = Conversion::default().value(name, &listed, 0)?;
    check(&flattened(&values, &mut numbers).ok_or_else(wrong)?)?;
    Ok(numbers)
}

/// The shape of nested lists of numbers, which are appended in order.
fn flattened(value: &Value, numbers: &mut Vec<f64>) -> Option<Vec<usize>> {
    let items = match value {
        Value::Array(items) => items,
        Value::Integer(_) | Value::Float(_) => {
            numbers.push(value.as_float().or(value.as_integer().map(|number| number as f64))?);
            return Some(Vec::new());
        }
        _ => return None,
    };
    let mut shapes = items.iter().map(|item| flattened(item, numbers));
    let first = shapes.next().unwrap_or_else(|| Some(Vec::new()))?;
    let are_equal = shapes.all(|shape| shape.as_ref() == Some(&first));
    are_equal.then(|| [vec![items.len()], first].concat())
}

/// Maximum nesting of values in a configuration: ten times what it needs.
const MOST_NESTED: usize = 40;

/// Maximum size of a text in a configuration: that of the longest path.
const MOST_TEXT_BYTES: usize = 4096;

/// Bytes that every value of a configuration counts, in addition to those of its text.
const VALUE_BYTES: u64 = 8;

/// The only conversion from Python values to configurations. It terminates for any input: containers that
/// contain themselves, share their parts or never end cost no more than a file of the maximum size.
struct Conversion {
    bytes_left: u64,
}

impl Default for Conversion {
    fn default() -> Self {
        Self { bytes_left: MAX_CONFIG_BYTES }
    }
}

impl Conversion {
    fn charge(&mut self, py: Python<'_>, name: &str, bytes: usize) -> PyResult<()> {
        let left = self.bytes_left.checked_sub(bytes as u64 + VALUE_BYTES);
        self.bytes_left = left.ok_or_else(|| {
            let most = format!("expected at most {MAX_CONFIG_BYTES} bytes in all");
            input_error(py, format!("`{name}` is too large for a configuration, {most}"))
        })?;
        Ok(())
    }

    fn table(&mut self, section: &str, dict: &Bound<'_, PyDict>, depth: usize) -> PyResult<Table> {
        let mut table = Table::new();
        // Code called for a value may change the dict: the entries are copied first.
        for entry in dict.items() {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = entry.extract()?;
            if value.is_none() {
                continue;
            }
            let name = key.cast::<PyString>().map_err(|_| {
                let problem = format!("a key of the configuration is {}, expected a string", shown(&key));
                input_error(dict.py(), problem)
            })?;
            let key = self.text("a key", name)?;
            let name = if section.is_empty() { key.clone() } else { format!("{section}.{key}") };
            table.insert(key, self.value(&name, &value, depth)?);
        }
        Ok(table)
    }

    fn text(&mut self, name: &str, text: &Bound<'_, PyString>) -> PyResult<String> {
        let py = text.py();
        let text = text.to_str().map_err(|_| {
            input_error(py, format!("`{name}` is {}, expected Unicode characters", shown(text)))
        })?;
        if text.len() > MOST_TEXT_BYTES {
            let problem = format!("`{name}` is a string of {} bytes", text.len());
            return Err(input_error(py, format!("{problem}, expected at most {MOST_TEXT_BYTES}")));
        }
        self.charge(py, name, text.len())?;
        Ok(text.to_owned())
    }

    fn value(&mut self, name: &str, value: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
        let py = value.py();
        self.charge(py, name, 0)?;
        if depth > MOST_NESTED {
            let most = format!("expected at most {MOST_NESTED} nested values");
            return Err(input_error(
                py,
                format!("`{name}` is nested too deeply, {most}; does it contain itself?"),
            ));
        }
        if let Ok(value) = value.cast::<PyBool>() {
            return Ok(Value::Boolean(value.is_true()));
        }
        if let Ok(text) = value.cast::<PyString>() {
            return Ok(Value::String(self.text(name, text)?));
        }
        if let Ok(dict) = value.cast::<PyDict>() {
            return Ok(Value::Table(self.table(name, dict, depth + 1)?));
        }
        let is_matrix = value.cast::<PyUntypedArray>().is_ok_and(|array| array.ndim() == 2);
        if is_matrix || value.is_instance_of::<View>() {
            let pose = pose_of(name, value)?;
            return Value::try_from(pose).map_err(|error| internal_error(py, &error.to_string()));
        }
        if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
            let items = value.try_iter()?.map(|item| self.value(name, &item?, depth + 1));
            return Ok(Value::Array(items.collect::<PyResult<_>>()?));
        }
        if is_planner(name)
            && let Ok(class) = value.cast::<PyType>()
        {
            return Ok(Value::String(planner_class::name_of(class)?));
        }
        self.number(name, value)
    }

    /// Converts a number of Python or numpy, or a path.
    fn number(&mut self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
        let py = value.py();
        let is_int = value.is_instance_of::<PyInt>() || value.hasattr("__index__")?;
        if is_int && let Some(int) = fitting(value.extract::<i64>(), py)? {
            return Ok(Value::Integer(int));
        }
        let is_float = value.is_instance_of::<PyFloat>() || (value.hasattr("__float__")? && !is_int);
        if is_float && let Some(float) = fitting(value.extract::<f64>(), py)? {
            return Ok(Value::Float(float));
        }
        if value.hasattr("__fspath__")? {
            let path = value.call_method0("__fspath__")?;
            return Ok(Value::String(self.text(name, path.cast::<PyString>()?)?));
        }
        let kind = type_of(value);
        if let Ok(array) = value.cast::<PyUntypedArray>() {
            let problem = format!("`{name}` is an array of the shape {:?}", array.shape());
            return Err(input_error(py, format!("{problem}, expected a list: pass its `tolist()`")));
        }
        if is_planner(name) {
            let expected = "expected a name, or a class: a subclass of nextview.Planner or nextview.Gain";
            let problem =
                format!("`{name}` is of type {kind}, {expected}; pass the class, not an object of it");
            return Err(input_error(py, problem));
        }
        let expected = "expected a string, a bool, a number of 64 bits, a list or a dict";
        Err(input_error(py, format!("`{name}` is of type {kind}, or out of range: {expected}")))
    }
}

fn is_planner(name: &str) -> bool {
    name.rsplit('.').next() == Some("planner")
}

/// The number; `None` if the value is not a number or does not fit. Any other exception is passed on.
fn fitting<T>(number: PyResult<T>, py: Python<'_>) -> PyResult<Option<T>> {
    match number {
        Ok(number) => Ok(Some(number)),
        Err(error) if error.is_instance_of::<PyTypeError>(py) => Ok(None),
        Err(error) if error.is_instance_of::<PyOverflowError>(py) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Reads the configuration in a file.
#[pyfunction]
pub fn read_config(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let read = || ScanConfig::parse(&files::read_text(&path, MAX_CONFIG_BYTES)?, Some(&path), None);
    to_python(py, &compute(py, &Cancel::default(), read)?)
}

/// Maximum size of a configuration, in a file or as values.
const MAX_CONFIG_BYTES: u64 = 1 << 20;

/// Names of the planners with a one-line description each.
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
