use super::timing::between;
use crate::collision::{Checker, Contact};
use nextview::{Cancel, Cancelled};
use std::collections::VecDeque;

/// Returns the first collision found on the straight line between joint values; `None` if the line is free.
///
/// The whole line is checked, not only samples: all distances at a sample, and the maximum motion of each
/// part, bound how much of the line around it is free (Schwarzer, Saha and Latombe 2005). On a free line,
/// distances are nowhere below the clearance by more than [`Checker::SLACK`].
///
/// # Panics
///
/// If the number of values is not that of joints, or one is not finite.
pub fn line_contact(
    checker: &Checker,
    from: &[f64],
    to: &[f64],
    cancel: &Cancel,
) -> Result<Option<Contact>, Cancelled> {
    let motion = checker.motion(from, to);
    let clear = |at: f64, most: f64| {
        cancel.check()?;
        Ok(checker.clear_share(&between(from, to, at), &motion, most))
    };
    let end = match clear(1.0, 1.0)? {
        Ok(share) => 1.0 - share,
        Err(contact) => return Ok(Some(contact)),
    };
    let start = match clear(0.0, 1.0)? {
        Ok(share) => share,
        Err(contact) => return Ok(Some(contact)),
    };
    // Widest gaps first, to find contacts early.
    let mut unknown = VecDeque::from([(start, end)]);
    while let Some((low, high)) = unknown.pop_front() {
        if low >= high {
            continue;
        }
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        match clear(middle, half)? {
            Ok(share) if share < half => unknown.extend([(low, middle - share), (middle + share, high)]),
            Ok(_) => {}
            Err(contact) => return Ok(Some(contact)),
        }
    }
    Ok(None)
}
