//! Python classes of planners and gains.

use crate::errors::{PlannerFailure, input_error};
use nextview::visibility::{FreeSpace, Sight};
use nextview_scan::ProvidedPlanner;
use pyo3::prelude::*;
use pyo3::types::PyType;

/// A class that makes planners.
pub struct Class<'py> {
    pub class: Bound<'py, PyType>,
    pub name: String,
    /// The rays of a gain; `None` for a planner.
    pub sight: Option<Sight>,
}

impl<'py> Class<'py> {
    /// Finds the class of a planner.
    pub fn find(py: Python<'py>, planner: &ProvidedPlanner) -> Result<Self, PlannerFailure> {
        let (module, name) = (planner.module(), planner.class().to_owned());
        if name.contains("<locals>") {
            return Err(PlannerFailure::new(format!(
                "{name} is defined in a function, so it cannot be found by name"
            )));
        }
        let Ok(class) = found(py, module, &name)?.cast_into::<PyType>() else {
            return Err(PlannerFailure::new(format!("{name} is not a class")));
        };
        let lookup = |error| PlannerFailure::raised(py, "its check", error);
        let is_a = |base: &str| class.is_subclass(&py.import("nextview")?.getattr(base)?);
        let sight = match (is_a("Planner").map_err(lookup)?, is_a("Gain").map_err(lookup)?) {
            (true, false) => None,
            (false, true) => Some(sight(&class, &name)?),
            (false, false) => {
                return Err(PlannerFailure::new(format!("{name} is neither a planner nor a gain")));
            }
            (true, true) => return Err(PlannerFailure::new(format!("{name} is both a planner and a gain"))),
        };
        let missing = class.getattr("__abstractmethods__").and_then(|names| names.try_iter()?.collect());
        let missing: Vec<Bound<'_, PyAny>> = missing.map_err(lookup)?;
        match missing.first() {
            Some(method) => Err(PlannerFailure::new(format!("{name} has no method `{method}`"))),
            None => Ok(Self { class, name, sight }),
        }
    }
}

/// The name of a class, by which scans find it. Fails if the name leads to another class, which would run in
/// its place: in a notebook, for example, a class is easily defined twice.
pub fn name_of(class: &Bound<'_, PyType>) -> PyResult<String> {
    let py = class.py();
    let (module, name) = (class.module()?.to_string(), class.qualname()?.to_string());
    let whole = format!("python:{module}:{name}");
    match found(py, &module, &name) {
        Ok(found) if !found.is(class) => Err(input_error(
            py,
            format!(
                "`planner` is a class {whole}, but that name refers to another class, such as a later \
                 definition: pass that class, or use different names"
            ),
        )),
        // A missing class is reported with all other faults.
        _ => Ok(whole),
    }
}

/// The object of this name in a module.
fn found<'py>(py: Python<'py>, module: &str, name: &str) -> Result<Bound<'py, PyAny>, PlannerFailure> {
    let mut found = imported(py, module).map_err(|error| PlannerFailure::raised(py, "its import", error))?;
    for part in name.split('.') {
        found = found.getattr(part).map_err(|error| PlannerFailure::raised(py, "its lookup", error))?;
    }
    Ok(found)
}

/// Returns the module. One that is still being imported, because it starts a scan, is not imported again: it
/// would wait for itself.
fn imported<'py>(py: Python<'py>, module: &str) -> PyResult<Bound<'py, PyAny>> {
    let known = py.import("sys")?.getattr("modules")?.call_method1("get", (module,))?;
    if known.is_none() { Ok(py.import(module)?.into_any()) } else { Ok(known) }
}

fn sight(class: &Bound<'_, PyType>, name: &str) -> Result<Sight, PlannerFailure> {
    let given = class.getattr("free_space").and_then(|value| value.extract::<String>());
    match given.as_deref() {
        Ok("clear") => Ok(Sight::endless(FreeSpace::Clear)),
        Ok("fades") => Ok(Sight::endless(FreeSpace::Fades)),
        Ok(other) => {
            Err(PlannerFailure::new(format!("{name}.free_space is {other:?}, expected clear or fades")))
        }
        Err(_) => {
            Err(PlannerFailure::new(format!("{name}.free_space is not a string, expected clear or fades")))
        }
    }
}
