use super::lists::Lists;

/// Visits of an edge after which the bound is left as it is: some 0.1 ms, a tenth of what the search may take.
const MAX_WORK: usize = 200_000;

/// Larger than the rounding errors of a bound, which is a sum of some thousand numbers.
const TOLERANCE: f64 = 1e-6;

/// A number of sets that no cover goes below, from the Lagrangian relaxation with subgradient steps (Beasley 1990);
/// the work ends when it reaches `known`, the size of a cover.
///
/// Every item offers a price. A set that takes what it costs, 1, or more from those it serves is taken, and all prices
/// less what the taken sets gain are never more than a cover costs. Prices of items served too often then fall, those
/// of unserved ones rise.
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

/// The bound at these prices, and for each item 1 less the number of taken sets that serve it.
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
    use crate::flow::Incidence;
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: every choice of sets.
        #[test]
        fn no_cover_is_smaller(
            rows in prop::collection::vec(prop::collection::vec(0_u32..10, 1..5), 1..20),
            spare in 0_usize..3,
        ) {
            let candidates = packed(&Incidence::from_rows(10, rows));
            let (items, sets) = (Lists::of(&candidates), Lists::of(&candidates.transposed()));
            let serves = |choice: &u32| candidates.iter().all(|row| row.columns().any(|set| choice >> set & 1 == 1));
            let fewest = (0_u32..1 << 10).filter(serves).map(|choice| choice.count_ones() as usize).min().unwrap();
            prop_assert!(fewest_possible(&items, &sets, fewest + spare) <= fewest);
        }
    }
}
