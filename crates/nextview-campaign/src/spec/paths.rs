use nextview_scan::Fault;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The path from the root of the file system on, so that it is the same from everywhere.
pub(super) fn whole_path(path: &Path) -> Result<String, Fault> {
    let whole = std::path::absolute(path).map_err(|e| Fault::from(e).in_file(path))?;
    let text = whole.into_os_string().into_string();
    text.map_err(|path| Fault::data("the name is not Unicode").in_file(&PathBuf::from(path)))
}

/// The value of a dotted key, which may be one key of the table or in nested tables.
pub(super) fn value_at<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Value> {
    if table.contains_key(key) {
        return table.get_mut(key);
    }
    let (first, rest) = key.split_once('.')?;
    value_at(table.get_mut(first)?.as_table_mut()?, rest)
}

/// Whether a table sets the value of a dotted key, or something of which it is a part.
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
