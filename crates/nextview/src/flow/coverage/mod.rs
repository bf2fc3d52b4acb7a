//! A few sets that together have the largest value: maximum coverage, with a value for each pair of item and
//! set (also known as uncapacitated facility location without costs, or as the k-median problem).

mod bound;
mod exact;
mod greedy;
mod set_values;
mod swap;

pub(crate) use set_values::tidied;
pub use set_values::{Selection, SetValues};

use crate::{Cancel, Cancelled};
use bound::Bound;
use exact::{Exact, branch_and_bound};
use greedy::{GreedyCoverage, greedy};

/// A few sets with a large joint value.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// The sets in greedy order: each gains most after those before it.
    pub sets: Vec<u32>,
    /// Their joint value.
    pub value: f64,
    /// Upper bound, to rounding, on the value of any selection of the same number of sets; `value` itself if
    /// the sets are proved optimal.
    pub bound: f64,
}

/// Returns at most `n_sets` sets of largest joint value.
///
/// Their value is at least 1 - 1/e of the optimum and usually equals it. Branch and bound improves on
/// [`good_coverage`], and the bound of the result states how far optimality is proved. The work is bounded by
/// counting steps, not time, so equal inputs give equal sets.
///
/// ```
/// use nextview::Cancel;
/// use nextview::flow::{SetValues, best_coverage};
///
/// // The first set has the largest value, but the other two together serve all.
/// let rows = [vec![1, 2, 3, 4], vec![0, 1, 2], vec![3, 4, 5]];
/// let values = rows.map(|items| items.into_iter().map(|item| (item, 1.0)).collect());
/// let best = best_coverage(&SetValues::new(6, values.into()), 2, &Cancel::default()).unwrap();
/// assert_eq!((best.sets, best.value, best.bound), (vec![1, 2], 6.0, 6.0));
/// ```
///
/// Fails if `cancel` is set.
pub fn best_coverage(values: &SetValues, n_sets: usize, cancel: &Cancel) -> Result<Coverage, Cancelled> {
    let (sets, bound) = greedy_with_swaps(values, n_sets, cancel)?;
    let bound = bound::lower(values, n_sets, bound, values.value_of(sets.iter().copied()), cancel)?;
    let Exact { sets, bound } = branch_and_bound(values, n_sets, sets, &bound, cancel)?;
    Ok(Coverage::new(values, sets, bound))
}

/// Returns at most `n_sets` sets with a large joint value, in a fraction of the time that [`best_coverage`]
/// takes for its proof: the greedy selection, whose value is at least 1 - 1/e of the best (Nemhauser, Wolsey
/// and Fisher 1978), after swaps of one set for another.
///
/// Fails if `cancel` is set.
pub fn good_coverage(values: &SetValues, n_sets: usize, cancel: &Cancel) -> Result<Coverage, Cancelled> {
    let (sets, bound) = greedy_with_swaps(values, n_sets, cancel)?;
    Ok(Coverage::new(values, sets, bound.value))
}

fn greedy_with_swaps(
    values: &SetValues,
    n_sets: usize,
    cancel: &Cancel,
) -> Result<(Vec<u32>, Bound), Cancelled> {
    let GreedyCoverage { sets, bound, served } = greedy(values, n_sets, cancel)?;
    let prices = served.into_iter().map(f64::from).collect();
    Ok((swap::swap(values, sets, cancel)?, Bound { value: bound, prices }))
}

impl Coverage {
    fn new(values: &SetValues, sets: Vec<u32>, bound: f64) -> Self {
        let sets = by_gain(values, sets);
        let value = values.value_of(sets.iter().copied());
        Self { sets, value, bound: bound.max(value) }
    }
}

/// The sets in greedy order, without those that gain nothing.
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

    fn best_of(values: &SetValues, n_sets: usize) -> Coverage {
        best_coverage(values, n_sets, &Cancel::default()).unwrap()
    }

    /// Problems of up to `n_sets` sets with many ties, and a number of sets to choose.
    pub fn instances(n_sets: usize) -> impl Strategy<Value = (SetValues, usize)> {
        let value = prop_oneof![
            prop::sample::select(vec![0.5_f32, 1.0, 2.0]),
            (0.01..3.0).prop_map(|value| value as f32)
        ];
        let row = prop::collection::vec((0_u32..15, value), 0..8);
        (prop::collection::vec(row, 0..=n_sets).prop_map(|rows| SetValues::new(15, rows)), 0_usize..6)
    }

    /// The value of the best choice, by brute force.
    pub fn best_by_trial(values: &SetValues, n_sets: usize) -> f64 {
        let choices = (0_u32..1 << values.n_sets()).filter(|choice| choice.count_ones() as usize <= n_sets);
        let value =
            |choice: u32| values.value_of((0..values.n_sets() as u32).filter(|set| choice >> set & 1 == 1));
        choices.map(value).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn small_problems_are_solved((values, n_sets) in instances(12)) {
            let found = best_of(&values, n_sets);
            let best = best_by_trial(&values, n_sets);
            prop_assert!((found.value - best).abs() <= 2e-9 * best, "{} of {}", found.value, best);
            prop_assert!((found.bound - best).abs() <= 2e-9 * best, "{} of {}", found.bound, best);
            prop_assert!(found.sets.len() <= n_sets);
            prop_assert_eq!(values.value_of(found.sets.iter().copied()), found.value);
            let mut selection = Selection::new(&values);
            let gains: Vec<f64> = found.sets.iter().map(|&set| selection.add(set)).collect();
            prop_assert!(gains.is_sorted_by(|a, b| a >= b) && gains.iter().all(|gain| *gain > 0.0));
        }
    }

    #[test]
    fn nothing_to_choose_has_no_value() {
        let nothing = Coverage { sets: Vec::new(), value: 0.0, bound: 0.0 };
        assert_eq!(best_of(&SetValues::new(0, vec![]), 3), nothing);
        assert_eq!(best_of(&SetValues::new(4, vec![vec![], vec![]]), 3), nothing);
        assert_eq!(best_of(&SetValues::new(4, vec![vec![(1, 1.0)]]), 0), nothing);
        let all = best_of(&SetValues::new(4, vec![vec![(1, 1.0)]]), usize::MAX);
        assert_eq!((all.sets, all.value, all.bound), (vec![0], 1.0, 1.0));
    }
}
