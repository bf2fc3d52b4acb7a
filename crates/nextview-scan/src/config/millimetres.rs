//! Lengths in metres that are so large that they were probably given in millimetres.

use crate::Fault;

/// A minimum depth above this, in metres, was probably given in another unit.
const LEAST_DEPTH_M: f64 = 20.0;

/// The fault of a minimum depth that no camera has.
pub(super) fn of_least_depth(key: &str, min_depth_m: f64) -> Option<Fault> {
    let fault = || Fault::of_value(key, min_depth_m, format!("at most {LEAST_DEPTH_M} m"));
    (min_depth_m > LEAST_DEPTH_M).then(|| in_millimetres(fault()))
}

/// Marks a fault in a length as probably given in millimetres.
pub(super) fn in_millimetres(mut fault: Fault) -> Fault {
    fault.message += "; is it in millimetres?";
    fault
}
