use super::timing::between;
use crate::collision::{Checker, Contact};
use nextview::{Cancel, Cancelled};
use std::collections::VecDeque;

/// The first collision on the straight line between joint values, in the order of checking; none if the line
/// is free.
///
/// The whole line is checked and not only samples: at each sample, all distances together with how far each
/// part can move at most tell how much of the line around it is free (Schwarzer, Saha and Latombe 2005). On
/// a free line, distances are nowhere below the clearance by more than [`Checker::SLACK`].
///
/// # Panics
///
/// If there are not as many values as joints, or one is not finite.
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
    // The widest gaps first: contacts are found early.
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
