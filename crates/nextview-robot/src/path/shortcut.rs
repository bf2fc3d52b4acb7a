use super::line::line_contact;
use super::timing::{between, duration};
use crate::collision::Checker;
use nextview::geometry::random::Random;
use nextview::{Cancel, Cancelled};

/// Maximum displacement of a corner in radians or metres.
const FARTHEST: f64 = 1.0;

/// Speeds up a free path by `n_tries` random changes that keep it free: shortcuts, and moved corners.
pub(super) fn shorten(
    checker: &Checker,
    mut corners: Vec<Vec<f64>>,
    random: &mut Random,
    n_tries: usize,
    cancel: &Cancel,
) -> Result<Vec<Vec<f64>>, Cancelled> {
    let arm = checker.arm();
    let mut time = duration(arm, &corners);
    for _ in 0..n_tries {
        if corners.len() == 2 {
            break;
        }
        let is_moved = random.unit() < 0.5;
        let (changed, new_legs) = if is_moved { moved(&corners, random) } else { cut(&corners, random) };
        let changed_time = duration(arm, &changed);
        let is_within = changed.iter().all(|values| arm.is_within_limits(values));
        if changed_time >= time || !is_within {
            continue;
        }
        let mut is_free = true;
        for leg in new_legs {
            let contact = line_contact(checker, &changed[leg], &changed[leg + 1], cancel)?;
            is_free = is_free && contact.is_none();
        }
        if is_free {
            (corners, time) = (changed, changed_time);
        }
    }
    Ok(corners)
}

/// Shortcuts a path with a straight line from a random point, half of the time a corner, to another; returns
/// the new legs, too.
fn cut(corners: &[Vec<f64>], random: &mut Random) -> (Vec<Vec<f64>>, Vec<usize>) {
    let n_legs = corners.len() - 1;
    let mut point = || {
        let at = random.range(0.0, n_legs as f64);
        if random.unit() < 0.5 { at.round() } else { at }
    };
    let (a, b) = (point(), point());
    let (a, b) = (a.min(b), a.max(b));
    let at = |at: f64| {
        let leg = (at as usize).min(n_legs - 1);
        between(&corners[leg], &corners[leg + 1], at - leg as f64)
    };
    let mut changed = corners[..=a as usize].to_vec();
    if a.fract() > 0.0 {
        changed.push(at(a));
    }
    let new_leg = changed.len() - 1;
    if b.fract() > 0.0 {
        changed.push(at(b));
    }
    changed.extend_from_slice(&corners[b.ceil() as usize..]);
    let legs = if changed.len() > new_leg + 1 && b > a { vec![new_leg] } else { vec![] };
    (changed, legs)
}

/// Moves a random inner corner of a path; returns the new legs, too.
fn moved(corners: &[Vec<f64>], random: &mut Random) -> (Vec<Vec<f64>>, Vec<usize>) {
    let corner = 1 + random.index(corners.len() - 2);
    let size = FARTHEST * random.unit().powi(2);
    let mut changed = corners.to_vec();
    changed[corner].iter_mut().for_each(|value| *value += size * random.range(-1.0, 1.0));
    (changed, vec![corner - 1, corner])
}
