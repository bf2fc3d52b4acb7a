use super::{CellError, Checker};
use crate::Arm;
use nextview::geometry::random::Random;
use std::f64::consts::TAU as TURN;

/// Number of configurations tried.
const N_TRIED: usize = 1000;

/// A pair that touches in more than this share of the configurations is assumed to touch because of its
/// shapes, whatever the joint values.
const ALWAYS: f64 = 0.95;

/// The pairs of links that may touch: those stated by the arm, neighbours, and those that touch in almost all
/// of a thousand random but fixed configurations. Sorted, lower number first.
///
/// Fails if a shape has no size or a joint has no limits.
pub fn touching_links(arm: &Arm) -> Result<Vec<[usize; 2]>, CellError> {
    let mut may_touch = arm.may_touch.clone();
    may_touch.extend((1..arm.links.len()).map(|link| [link - 1, link]));
    let checker = Checker::new(Arm { may_touch: may_touch.clone(), ..arm.clone() }, vec![], vec![], 0.01)?;
    let n = arm.links.len();
    let mut n_touching = vec![0; n * n];
    let mut random = Random::new(0, 0);
    for _ in 0..N_TRIED {
        let limits = arm.joints.iter().map(|joint| joint.limits);
        // The range of a joint without limits is infinite; one turn covers all of it.
        let ranges = limits.map(|limits| (limits.lower.max(-TURN), limits.upper.min(TURN)));
        let values: Vec<f64> = ranges.map(|(low, high)| random.range(low, high)).collect();
        checker.touching(&values).for_each(|[a, b]| n_touching[a * n + b] += 1);
    }
    let is_always = |pair: &usize| n_touching[*pair] as f64 > ALWAYS * N_TRIED as f64;
    may_touch.extend((0..n * n).filter(is_always).map(|pair| [pair / n, pair % n]));
    may_touch.sort_unstable();
    may_touch.dedup();
    Ok(may_touch)
}
