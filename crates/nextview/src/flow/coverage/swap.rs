use super::SetValues;
use crate::{Cancel, Cancelled};
use rayon::prelude::*;

/// Pairs of item and set visited after which the search ends, about a second.
const MAX_WORK: usize = 500_000_000;

/// Gains below this share of the present value may be rounding errors.
const LEAST_GAIN: f64 = 1e-9;

/// Swaps one set for another as long as that gains anything, each time the pair that gains most. The sets are
/// returned in the order given, with each substitute in the place of its original.
///
/// All pairs are rated in one pass over the sets: the fast interchange of Whitaker (1983).
pub(super) fn swap(values: &SetValues, mut chosen: Vec<u32>, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
    for _ in 0..MAX_WORK / values.n_pairs().max(1) {
        let service = SetService::of(values, &chosen);
        let sets = (0..values.n_sets() as u32).into_par_iter().filter(|set| !chosen.contains(set));
        let swaps = sets.map(|set| cancel.check().map(|()| service.best_swap(values, set)));
        let swaps: Vec<Option<Swap>> = swaps.collect::<Result<_, Cancelled>>()?;
        let best =
            swaps.into_iter().flatten().reduce(|best, swap| if swap.gain > best.gain { swap } else { best });
        match best {
            Some(best) if best.gain > LEAST_GAIN * service.value() => chosen[best.place] = best.set,
            _ => break,
        }
    }
    Ok(chosen)
}

/// A set that replaces a chosen one, and the gain.
struct Swap {
    gain: f64,
    set: u32,
    place: usize,
}

/// How well the chosen sets serve the items.
struct SetService {
    /// By item, the largest value in a chosen set, and the place of that set among the chosen.
    first: Vec<(f32, u32)>,
    /// By item, the largest value in the other chosen sets.
    second: Vec<f32>,
    /// By place, the loss of value without the set.
    loss: Vec<f64>,
}

impl SetService {
    fn of(values: &SetValues, chosen: &[u32]) -> Self {
        let n_items = values.n_items();
        let (mut first, mut second) = (vec![(0.0, 0); n_items], vec![0.0; n_items]);
        for (place, &set) in chosen.iter().enumerate() {
            for &(item, value) in values.row(set) {
                let (first, second) = (&mut first[item as usize], &mut second[item as usize]);
                if value > first.0 {
                    *second = first.0;
                    *first = (value, place as u32);
                } else if value > *second {
                    *second = value;
                }
            }
        }
        let mut loss = vec![0.0; chosen.len()];
        for (&(value, place), &second) in first.iter().zip(&second).filter(|((value, _), _)| *value > 0.0) {
            loss[place as usize] += value as f64 - second as f64;
        }
        Self { first, second, loss }
    }

    fn value(&self) -> f64 {
        self.first.iter().fold(0.0, |sum, &(value, _)| sum + value as f64)
    }

    /// The best place for this set, the first on ties.
    fn best_swap(&self, values: &SetValues, set: u32) -> Option<Swap> {
        let mut gain = 0.0;
        // The part of the loss of each other set that this set makes up for.
        let mut saved = vec![0.0; self.loss.len()];
        for &(item, value) in values.row(set) {
            let ((first, place), second) = (self.first[item as usize], self.second[item as usize]);
            gain += (value as f64 - first as f64).max(0.0);
            if value > second && first > 0.0 {
                saved[place as usize] += value.min(first) as f64 - second as f64;
            }
        }
        let swap = |place: usize| Swap { gain: gain + saved[place] - self.loss[place], set, place };
        let swaps = (0..self.loss.len()).map(swap);
        swaps.reduce(|best, swap| if swap.gain > best.gain { swap } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::instances;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ends_where_no_swap_gains((values, n_sets) in instances(12)) {
            let start: Vec<u32> = (0..n_sets.min(values.n_sets()) as u32).collect();
            let found = swap(&values, start.clone(), &Cancel::default()).unwrap();
            prop_assert_eq!(found.len(), start.len());
            let value = values.value_of(found.iter().copied());
            prop_assert!(value >= values.value_of(start) * (1.0 - 1e-12));
            for place in 0..found.len() {
                for set in 0..values.n_sets() as u32 {
                    let mut other = found.clone();
                    other[place] = set;
                    prop_assert!(values.value_of(other) <= value * (1.0 + 2.0 * LEAST_GAIN));
                }
            }
        }
    }
}
