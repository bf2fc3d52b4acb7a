//! Python values as messages show them.

use pyo3::prelude::*;

/// Maximum length of a value in a message, in characters.
const MOST_SHOWN: usize = 80;

/// The beginning of a value's `repr`, however large the value.
pub fn shown(value: &Bound<'_, PyAny>) -> String {
    let repr = || value.py().import("reprlib")?.call_method1("repr", (value,))?.extract::<String>();
    let text = repr().unwrap_or_else(|_: PyErr| "?".to_owned());
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// The type of a value.
pub fn type_of(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string_lossy().into_owned())
}
