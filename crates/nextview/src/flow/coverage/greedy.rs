use super::{Selection, SetValues};
use rayon::prelude::*;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// What greedy choice finds.
pub(super) struct Greedy {
    /// The sets in the order of the choice; fewer than asked for if no other gains anything.
    pub sets: Vec<u32>,
    /// No choice of as many sets as asked for is worth more.
    pub bound: f64,
    /// By item, how well it was served when the bound was found.
    pub served: Vec<f32>,
}

/// Takes the set of largest gain, the lowest of several, up to `n_sets` times. The result is worth at least 1 - 1/e of the
/// best (Nemhauser, Wolsey and Fisher 1978).
///
/// Whatever was taken so far, the best choice is worth no more than that and the `n_sets` largest gains, since gains only fall;
/// the least of these is the bound. And since they only fall, most need not be found anew (Minoux 1978).
pub(super) fn greedy(values: &SetValues, n_sets: usize) -> Greedy {
    let mut selection = Selection::new(values);
    let mut offers = first_offers(&selection);
    let (mut worth, mut sets) = (0.0, Vec::new());
    let mut best = Greedy { sets: Vec::new(), bound: f64::INFINITY, served: Vec::new() };
    loop {
        let largest = largest_offers(&mut offers, &selection, n_sets, sets.len());
        let bound = worth + largest.iter().map(|offer| offer.gain).sum::<f64>();
        if bound < best.bound {
            (best.bound, best.served) = (bound, selection.served().to_vec());
        }
        let Some(first) = largest.first().filter(|first| first.gain > 0.0 && sets.len() < n_sets) else {
            return Greedy { sets, ..best };
        };
        worth += selection.add(first.set);
        sets.push(first.set);
        offers.extend(largest.into_iter().skip(1));
    }
}

/// A set and its gain when so many sets were taken.
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

fn first_offers(selection: &Selection<'_>) -> BinaryHeap<Offer> {
    let sets = (0..selection.values.n_sets() as u32).into_par_iter();
    sets.map(|set| Offer::new(selection, set, 0)).collect::<Vec<_>>().into()
}

/// Takes out the `n` offers of largest gain under the selection of `n_taken` sets, the largest first.
fn largest_offers(
    offers: &mut BinaryHeap<Offer>,
    selection: &Selection<'_>,
    n: usize,
    n_taken: usize,
) -> Vec<Offer> {
    let mut largest = Vec::new();
    while largest.len() < n {
        match offers.pop() {
            None => break,
            Some(offer) if offer.n_taken == n_taken => largest.push(offer),
            Some(offer) => offers.push(Offer::new(selection, offer.set, n_taken)),
        }
    }
    largest
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
        let (mut selection, mut sets, mut worth, mut bound) =
            (Selection::new(values), Vec::new(), 0.0, f64::INFINITY);
        loop {
            let mut gains: Vec<(f64, u32)> =
                (0..values.n_sets() as u32).map(|set| (selection.gain(set), set)).collect();
            gains.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            bound = f64::min(bound, worth + gains.iter().take(n_sets).map(|gain| gain.0).sum::<f64>());
            match gains.first() {
                Some(&(gain, set)) if gain > 0.0 && sets.len() < n_sets => {
                    worth += selection.add(set);
                    sets.push(set);
                }
                _ => return (sets, bound),
            }
        }
    }

    proptest! {
        #[test]
        fn is_plain_greedy_within_its_guarantee((values, n_sets) in instances(12)) {
            let found = greedy(&values, n_sets);
            let (sets, bound) = plain(&values, n_sets);
            prop_assert_eq!(&found.sets, &sets);
            prop_assert_eq!(found.bound, bound);
            let best = best_by_trial(&values, n_sets);
            prop_assert!(found.bound >= best * (1.0 - 1e-12));
            let guaranteed = (1.0 - (-1.0_f64).exp()) * best;
            prop_assert!(values.worth(found.sets) >= guaranteed * (1.0 - 1e-12));
        }
    }
}
