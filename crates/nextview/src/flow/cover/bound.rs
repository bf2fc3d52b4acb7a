use super::lists::Lists;

/// Edge visits after which the bound is not tightened further: about 0.1 ms, a tenth of the time allowed for
/// the search.
const MAX_WORK: usize = 200_000;

/// Larger than the rounding errors of a bound, which is a sum of some thousand numbers.
const TOLERANCE: f64 = 1e-6;

/// Returns a lower bound on the size of every cover, by Lagrangian relaxation with subgradient steps (Beasley
/// 1990). The iteration ends when it reaches `known`, the size of a known cover.
///
/// Every item offers a price. A set is taken if the prices of the items it serves add up to at least its
/// cost, 1. The sum of all prices minus the profits of the taken sets never exceeds the cost of a cover. Then
/// the prices of items served more than once fall, and those of unserved items rise.
pub(super) fn fewest_possible(candidates: &Lists, by_set: &Lists, known: usize) -> usize {
    let n_items = candidates.n_rows() as u32;
    let share = |set: &u32| 1.0 / by_set.row(*set).len() as f64;
    let mut prices: Vec<f64> =
        (0..n_items).map(|item| candidates.row(item).iter().map(share).fold(1.0, f64::min)).collect();
    let (mut best, mut pace, mut n_stale) = (0.0, 1.0, 0);
    let mut lacking = vec![0.0; n_items as usize];
    for _ in 0..MAX_WORK / (2 * candidates.n_pairs()).max(1) {
        let bound = relax(by_set, &prices, &mut lacking);
        n_stale += 1;
        if bound > best + TOLERANCE {
            (best, n_stale) = (bound, 0);
        } else if n_stale == 5 {
            (pace, n_stale) = (0.5 * pace, 0);
        }
        let n_wrong: f64 = lacking.iter().map(|n| n * n).sum();
        if best > known as f64 - 1.0 + TOLERANCE || n_wrong == 0.0 {
            break;
        }
        let step = pace * (known as f64 - bound) / n_wrong;
        prices
            .iter_mut()
            .zip(&lacking)
            .for_each(|(price, lacking)| *price = (*price + step * lacking).max(0.0));
    }
    (best - TOLERANCE).ceil() as usize
}

/// The bound at these prices, and for each item 1 minus the number of taken sets that serve it.
fn relax(by_set: &Lists, prices: &[f64], lacking: &mut [f64]) -> f64 {
    lacking.fill(1.0);
    let mut bound: f64 = prices.iter().sum();
    for set in 0..by_set.n_rows() as u32 {
        let items = by_set.row(set);
        let cost = 1.0 - items.iter().map(|&item| prices[item as usize]).sum::<f64>();
        if cost < 0.0 {
            bound += cost;
            items.iter().for_each(|&item| lacking[item as usize] -= 1.0);
        }
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::super::packed;
    use super::*;
    use crate::Cancel;
    use crate::flow::Incidence;
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: every selection of sets.
        #[test]
        fn no_cover_is_smaller(
            rows in prop::collection::vec(prop::collection::vec(0_u32..10, 1..5), 1..20),
            spare in 0_usize..3,
        ) {
            let never = &Cancel::default();
            let candidates = packed(&Incidence::from_rows(10, rows), never).unwrap();
            let (items, sets) = (Lists::of(&candidates), Lists::of(&candidates.transposed(never).unwrap()));
            let serves = |choice: &u32| candidates.iter().all(|row| row.columns().any(|set| choice >> set & 1 == 1));
            let fewest = (0_u32..1 << 10).filter(serves).map(|choice| choice.count_ones() as usize).min().unwrap();
            prop_assert!(fewest_possible(&items, &sets, fewest + spare) <= fewest);
        }
    }
}
