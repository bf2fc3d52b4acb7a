use nextview_scan::Fault;
use std::collections::BTreeSet;
use std::fmt::Debug;

/// Fails unless there is at least one value and no duplicate.
pub(super) fn check_distinct<T: Debug>(field: &str, values: &[T]) -> Result<(), Fault> {
    if values.is_empty() {
        return Err(Fault::data(format!("{field} is empty, expected at least one value")));
    }
    // Compared by their texts, which have an order: a specification may list a hundred thousand.
    let mut known = BTreeSet::new();
    let twice = values.iter().map(|value| format!("{value:?}")).find(|text| !known.insert(text.clone()));
    twice.map_or(Ok(()), |text| Err(Fault::data(format!("{field} has {text} twice"))))
}
