use nextview_scan::Fault;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The absolute path, valid from everywhere.
pub(super) fn whole_path(path: &Path) -> Result<String, Fault> {
    let whole = std::path::absolute(path).map_err(|e| Fault::from(e).in_file(path))?;
    let text = whole.into_os_string().into_string();
    text.map_err(|path| Fault::data("the name is not Unicode").in_file(&PathBuf::from(path)))
}

/// The value of a dotted key, which may be a single key of the table, dots included, or a path through nested
/// tables.
pub(super) fn value_at<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Value> {
    if table.contains_key(key) {
        return table.get_mut(key);
    }
    let (first, rest) = key.split_once('.')?;
    value_at(table.get_mut(first)?.as_table_mut()?, rest)
}

/// Whether a table sets the value of a dotted key, or a parent of it.
pub(super) fn sets(table: &Table, key: &str) -> bool {
    if table.contains_key(key) {
        return true;
    }
    let Some((first, rest)) = key.split_once('.') else { return false };
    match table.get(first) {
        Some(Value::Table(table)) => sets(table, rest),
        value => value.is_some(),
    }
}
