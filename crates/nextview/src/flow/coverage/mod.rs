//! A few sets that together are worth as much as possible: maximum coverage, with a value for each pair of item and set (then
//! also known as uncapacitated facility location without costs, or as the k-median problem).

mod bound;
mod exact;
mod greedy;
mod set_values;
mod swap;

pub use set_values::{Selection, SetValues};

use bound::Bound;
use exact::{Exact, branch_and_bound};
use greedy::{Greedy, greedy};

/// Some sets that together are worth much.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// The sets; each gains most after those before it.
    pub sets: Vec<u32>,
    /// What they are worth together.
    pub worth: f64,
    /// No choice of as many sets is worth more, to rounding; `worth` itself where they were proved to be the best.
    pub bound: f64,
}

/// At most `n_sets` sets that together are worth as much as possible.
///
/// They are worth at least 1 - 1/e of the best choice, and mostly are the best: this is a [`good_coverage`] made better
/// by branch and bound, with a bound that tells how far that is proved. The work is bounded by counting steps, not time, so
/// the same input gives the same sets.
///
/// ```
/// use nextview::flow::{SetValues, best_coverage};
///
/// // The first set is worth most, but the other two together serve all.
/// let rows = [vec![1, 2, 3, 4], vec![0, 1, 2], vec![3, 4, 5]];
/// let values = rows.map(|items| items.into_iter().map(|item| (item, 1.0)).collect());
/// let best = best_coverage(&SetValues::new(6, values.into()), 2);
/// assert_eq!((best.sets, best.worth, best.bound), (vec![1, 2], 6.0, 6.0));
/// ```
pub fn best_coverage(values: &SetValues, n_sets: usize) -> Coverage {
    let (sets, bound) = greedy_with_swaps(values, n_sets);
    let bound = bound::lower(values, n_sets, bound, values.worth(sets.iter().copied()));
    let Exact { sets, bound } = branch_and_bound(values, n_sets, sets, &bound);
    Coverage::new(values, sets, bound)
}

/// At most `n_sets` sets that together are worth much, in a fraction of the time that [`best_coverage`] takes to prove it:
/// the greedy choice, worth at least 1 - 1/e of the best (Nemhauser, Wolsey and Fisher 1978), after swaps of one set for
/// another.
pub fn good_coverage(values: &SetValues, n_sets: usize) -> Coverage {
    let (sets, bound) = greedy_with_swaps(values, n_sets);
    Coverage::new(values, sets, bound.value)
}

fn greedy_with_swaps(values: &SetValues, n_sets: usize) -> (Vec<u32>, Bound) {
    let Greedy { sets, bound, served } = greedy(values, n_sets);
    let prices = served.into_iter().map(f64::from).collect();
    (swap::swap(values, sets), Bound { value: bound, prices })
}

impl Coverage {
    fn new(values: &SetValues, sets: Vec<u32>, bound: f64) -> Self {
        let sets = by_gain(values, sets);
        let worth = values.worth(sets.iter().copied());
        Self { sets, worth, bound: bound.max(worth) }
    }
}

/// The sets in greedy order, those that gain nothing left out.
fn by_gain(values: &SetValues, mut sets: Vec<u32>) -> Vec<u32> {
    sets.sort_unstable();
    let mut selection = Selection::new(values);
    let mut ordered = Vec::new();
    while !sets.is_empty() {
        let gains = sets.iter().map(|&set| selection.gain(set)).enumerate();
        let (place, gain) =
            gains.reduce(|best, gain| if gain.1 > best.1 { gain } else { best }).unwrap_or_default();
        if gain == 0.0 {
            break;
        }
        let set = sets.remove(place);
        selection.add(set);
        ordered.push(set);
    }
    ordered
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Problems of up to so many sets, with many ties, and a number of sets to choose.
    pub fn instances(n_sets: usize) -> impl Strategy<Value = (SetValues, usize)> {
        let value = prop_oneof![prop::sample::select(vec![0.5_f32, 1.0, 2.0]), 0.01_f32..3.0];
        let row = prop::collection::vec((0_u32..15, value), 0..8);
        (prop::collection::vec(row, 0..=n_sets).prop_map(|rows| SetValues::new(15, rows)), 0_usize..6)
    }

    /// What the best choice is worth: all are tried.
    pub fn best_by_trial(values: &SetValues, n_sets: usize) -> f64 {
        let choices = (0_u32..1 << values.n_sets()).filter(|choice| choice.count_ones() as usize <= n_sets);
        let worth =
            |choice: u32| values.worth((0..values.n_sets() as u32).filter(|set| choice >> set & 1 == 1));
        choices.map(worth).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn small_problems_are_solved((values, n_sets) in instances(12)) {
            let found = best_coverage(&values, n_sets);
            let best = best_by_trial(&values, n_sets);
            prop_assert!((found.worth - best).abs() <= 2e-9 * best, "{} of {}", found.worth, best);
            prop_assert!((found.bound - best).abs() <= 2e-9 * best, "{} of {}", found.bound, best);
            prop_assert!(found.sets.len() <= n_sets);
            prop_assert_eq!(values.worth(found.sets.iter().copied()), found.worth);
            let mut selection = Selection::new(&values);
            let gains: Vec<f64> = found.sets.iter().map(|&set| selection.add(set)).collect();
            prop_assert!(gains.is_sorted_by(|a, b| a >= b) && gains.iter().all(|gain| *gain > 0.0));
        }
    }

    #[test]
    fn nothing_to_choose_is_worth_nothing() {
        let nothing = Coverage { sets: Vec::new(), worth: 0.0, bound: 0.0 };
        assert_eq!(best_coverage(&SetValues::new(0, vec![]), 3), nothing);
        assert_eq!(best_coverage(&SetValues::new(4, vec![vec![], vec![]]), 3), nothing);
        assert_eq!(best_coverage(&SetValues::new(4, vec![vec![(1, 1.0)]]), 0), nothing);
        let all = best_coverage(&SetValues::new(4, vec![vec![(1, 1.0)]]), usize::MAX);
        assert_eq!((all.sets, all.worth, all.bound), (vec![0], 1.0, 1.0));
    }
}
