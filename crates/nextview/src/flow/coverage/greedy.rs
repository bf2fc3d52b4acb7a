use super::{Selection, SetValues};
use crate::{Cancel, Cancelled};
use rayon::prelude::*;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Result of the greedy selection.
pub(super) struct GreedyCoverage {
    /// The sets in the order of selection; fewer than requested if no other gains anything.
    pub sets: Vec<u32>,
    /// Upper bound on the value of any selection of the requested number of sets.
    pub bound: f64,
    /// By item, how well it was served when the bound was found.
    pub served: Vec<f32>,
}

/// Takes the set of largest gain, the lowest number on ties, up to `n_sets` times. The value of the result is
/// at least 1 - 1/e of that of the best (Nemhauser, Wolsey and Fisher 1978).
///
/// Since gains only fall, the value of the best choice is at most the value of the sets taken so far plus the
/// `n_sets` largest gains; the smallest such sum is the bound. For the same reason, most gains need not be
/// computed again (Minoux 1978).
pub(super) fn greedy(
    values: &SetValues,
    n_sets: usize,
    cancel: &Cancel,
) -> Result<GreedyCoverage, Cancelled> {
    let mut selection = Selection::new(values);
    let mut offers = first_offers(&selection, cancel)?;
    let (mut value, mut sets) = (0.0, Vec::new());
    let mut best = GreedyCoverage { sets: Vec::new(), bound: f64::INFINITY, served: Vec::new() };
    loop {
        let largest = largest_offers(&mut offers, &selection, n_sets, sets.len(), cancel)?;
        let bound = value + largest.iter().map(|offer| offer.gain).sum::<f64>();
        if bound < best.bound {
            (best.bound, best.served) = (bound, selection.served().to_vec());
        }
        let Some(first) = largest.first().filter(|first| first.gain > 0.0 && sets.len() < n_sets) else {
            return Ok(GreedyCoverage { sets, ..best });
        };
        value += selection.add(first.set);
        sets.push(first.set);
        offers.extend(largest.into_iter().skip(1));
    }
}

/// A set and its gain when `n_taken` sets were taken.
#[derive(Clone, Copy)]
struct Offer {
    gain: f64,
    set: u32,
    n_taken: usize,
}

impl Offer {
    fn new(selection: &Selection<'_>, set: u32, n_taken: usize) -> Self {
        Self { gain: selection.gain(set), set, n_taken }
    }
}

fn first_offers(selection: &Selection<'_>, cancel: &Cancel) -> Result<BinaryHeap<Offer>, Cancelled> {
    let sets = (0..selection.values.n_sets() as u32).into_par_iter();
    let offers = sets.map(|set| cancel.check().map(|()| Offer::new(selection, set, 0)));
    Ok(offers.collect::<Result<Vec<_>, Cancelled>>()?.into())
}

/// Removes the `n` offers of largest gain under the selection of `n_taken` sets, the largest first.
fn largest_offers(
    offers: &mut BinaryHeap<Offer>,
    selection: &Selection<'_>,
    n: usize,
    n_taken: usize,
    cancel: &Cancel,
) -> Result<Vec<Offer>, Cancelled> {
    let mut largest = Vec::new();
    while largest.len() < n {
        cancel.check()?;
        match offers.pop() {
            None => break,
            Some(offer) if offer.n_taken == n_taken => largest.push(offer),
            Some(offer) => offers.push(Offer::new(selection, offer.set, n_taken)),
        }
    }
    Ok(largest)
}

/// By gain, then the lower set.
impl Ord for Offer {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(Reverse(self.set).cmp(&Reverse(other.set)))
    }
}

impl PartialOrd for Offer {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Offer {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Offer {}

#[cfg(test)]
mod tests {
    use super::super::tests::{best_by_trial, instances};
    use super::*;
    use proptest::prelude::*;

    /// The slow twin: all gains at every step.
    fn plain(values: &SetValues, n_sets: usize) -> (Vec<u32>, f64) {
        let (mut selection, mut sets, mut value, mut bound) =
            (Selection::new(values), Vec::new(), 0.0, f64::INFINITY);
        loop {
            let mut gains: Vec<(f64, u32)> =
                (0..values.n_sets() as u32).map(|set| (selection.gain(set), set)).collect();
            gains.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            bound = f64::min(bound, value + gains.iter().take(n_sets).map(|gain| gain.0).sum::<f64>());
            match gains.first() {
                Some(&(gain, set)) if gain > 0.0 && sets.len() < n_sets => {
                    value += selection.add(set);
                    sets.push(set);
                }
                _ => return (sets, bound),
            }
        }
    }

    proptest! {
        #[test]
        fn is_plain_greedy_within_its_guarantee((values, n_sets) in instances(12)) {
            let found = greedy(&values, n_sets, &Cancel::default()).unwrap();
            let (sets, bound) = plain(&values, n_sets);
            prop_assert_eq!(&found.sets, &sets);
            prop_assert_eq!(found.bound, bound);
            let best = best_by_trial(&values, n_sets);
            prop_assert!(found.bound >= best * (1.0 - 1e-12));
            let guaranteed = (1.0 - (-1.0_f64).exp()) * best;
            prop_assert!(values.value_of(found.sets) >= guaranteed * (1.0 - 1e-12));
        }
    }
}
