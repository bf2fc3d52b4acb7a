use nextview_scan::Fault;
use std::fmt::Debug;

/// Fails unless there is at least one value and none twice.
pub(super) fn check_distinct<T: PartialEq + Debug>(field: &str, values: &[T]) -> Result<(), Fault> {
    if values.is_empty() {
        return Err(Fault::data(format!("{field} is empty, expected at least one value")));
    }
    let twice = (1..values.len()).find(|&i| values[..i].contains(&values[i]));
    twice.map_or(Ok(()), |i| Err(Fault::data(format!("{field} has {:?} twice", values[i]))))
}
