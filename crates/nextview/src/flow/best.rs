use super::Incidence;
use crate::{Cancel, Cancelled};

/// Items processed between two checks for cancellation.
const CHUNK: usize = 1 << 16;

/// The best quality offered for each item, and the sets that offered it.
///
/// This is the optimal flow of the paper's eq. (3), found without a network. Only the edges from the source
/// have a capacity, so items do not compete: each takes a channel of largest quality and continues to any set
/// of that channel. A channel is therefore offered, not stored: once for each item on it and each set that
/// holds it. The choice among equally good sets remains; [`fewest_sets`](super::fewest_sets) makes it.
///
/// ```
/// use nextview::Cancel;
/// use nextview::flow::{BestSets, fewest_sets};
///
/// let mut best = BestSets::new(2, 10);
/// best.offer(0, 4, 0.5);
/// best.offer(0, 6, 0.5);
/// best.offer(0, 7, 0.1);
/// best.offer(1, 6, 0.2);
/// assert_eq!(best.quality(0), Some(0.5));
/// assert_eq!(best.sets(0).collect::<Vec<_>>(), [4, 6]);
/// assert_eq!(fewest_sets(best.candidates(), &Cancel::default()), Ok(vec![6]));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BestSets {
    /// 0 where nothing was offered. Stored apart from the sets, because nearly every offer needs only this
    /// comparison.
    quality: Vec<f64>,
    candidates: Incidence,
}

impl BestSets {
    /// Creates an accumulator without offers, for items below `n_items` and sets below `n_sets`.
    pub fn new(n_items: usize, n_sets: usize) -> Self {
        Self { quality: vec![0.0; n_items], candidates: Incidence::new(n_items, n_sets) }
    }

    /// Offers to serve an item from a set at some quality. A quality that is not positive, or NaN, is
    /// ignored.
    ///
    /// The order does not matter; sets in increasing order are cheapest.
    ///
    /// # Panics
    /// If the item or the set is out of range (unless the offer is refused for its quality).
    #[inline]
    pub fn offer(&mut self, item: usize, set: u32, quality: f64) {
        // Most offers of a scan have quality 0, because they concern measured voxels: these are rejected
        // without reading the item.
        if quality > 0.0 && quality >= self.quality[item] {
            self.accept(item, set, quality);
        }
    }

    /// Adds the offers of another accumulator. The result equals that of one accumulator for all offers,
    /// however they were divided.
    ///
    /// Fails if `cancel` is set, and then holds only some of the offers.
    ///
    /// # Panics
    /// If the two were made for different numbers of items or sets.
    pub fn merge(&mut self, mut other: Self, cancel: &Cancel) -> Result<(), Cancelled> {
        assert_eq!(
            (self.quality.len(), self.candidates.n_columns()),
            (other.quality.len(), other.candidates.n_columns()),
            "items and sets of the merged"
        );
        for item in 0..self.quality.len() {
            if item.is_multiple_of(CHUNK) {
                cancel.check()?;
            }
            if other.quality[item] > self.quality[item] {
                self.quality[item] = other.quality[item];
                self.candidates.take_row(item, &mut other.candidates);
            } else if other.quality[item] == self.quality[item] {
                self.candidates.unite_row(item, &other.candidates);
            }
        }
        Ok(())
    }

    /// Returns the largest quality offered for an item; `None` if there is no offer.
    pub fn quality(&self, item: usize) -> Option<f64> {
        Some(self.quality[item]).filter(|&quality| quality > 0.0)
    }

    /// Returns the sets that offered the largest quality for an item, in increasing order.
    pub fn sets(&self, item: usize) -> impl Iterator<Item = u32> + use<'_> {
        self.candidates.row(item)
    }

    /// Returns the [`sets`](Self::sets) of all items, one row each.
    pub fn candidates(&self) -> &Incidence {
        &self.candidates
    }

    /// Returns the sum of the largest qualities, in the order of the items: the quality of the optimal flow.
    pub fn total_quality(&self) -> f64 {
        self.quality.iter().fold(0.0, |sum, quality| sum + quality)
    }

    /// Returns the number of items with an offer.
    pub fn n_served(&self) -> usize {
        self.quality.iter().filter(|&&quality| quality > 0.0).count()
    }

    /// Kept out of line: the rare branch of the hottest loop.
    #[inline(never)]
    fn accept(&mut self, item: usize, set: u32, quality: f64) {
        if quality > self.quality[item] {
            self.quality[item] = quality;
            self.candidates.clear(item);
        }
        self.candidates.insert(item, set);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Offer = (usize, u32, f64);

    fn best_of(offers: &[Offer], n_sets: usize) -> BestSets {
        let mut best = BestSets::new(5, n_sets);
        offers.iter().for_each(|&(item, set, quality)| best.offer(item, set, quality));
        best
    }

    /// Offers with many ties, some of no value, and enough sets for both forms of a row.
    fn offers() -> impl Strategy<Value = Vec<Offer>> {
        let quality = prop::sample::select(vec![-1.0, 0.0, f64::NAN, 0.25, 0.5, 0.75]);
        prop::collection::vec((0_usize..5, 0_u32..100, quality), 0..300)
    }

    proptest! {
        #[test]
        fn the_result_does_not_depend_on_division_and_order(
            (offers, shuffled) in offers().prop_flat_map(|o| (Just(o.clone()), Just(o).prop_shuffle())),
            cut in 0.0..1.0,
        ) {
            let whole = best_of(&offers, 100);
            let (a, b) = shuffled.split_at((cut * shuffled.len() as f64) as usize);
            let mut merged = best_of(a, 100);
            merged.merge(best_of(b, 100), &Cancel::default()).unwrap();
            prop_assert_eq!(&merged, &whole);
            let mut other_way = best_of(b, 100);
            other_way.merge(best_of(a, 100), &Cancel::default()).unwrap();
            prop_assert_eq!(&other_way, &whole);
        }

        #[test]
        fn each_item_keeps_the_sets_of_its_largest_quality(offers in offers()) {
            let best = best_of(&offers, 100);
            for item in 0..5 {
                let mine = || offers.iter().filter(|o| o.0 == item && o.2 > 0.0);
                let largest = mine().map(|o| o.2).fold(0.0, f64::max);
                let mut sets: Vec<u32> = mine().filter(|o| o.2 == largest).map(|o| o.1).collect();
                sets.sort_unstable();
                sets.dedup();
                prop_assert_eq!(best.quality(item).unwrap_or(0.0), largest);
                prop_assert_eq!(best.sets(item).collect::<Vec<_>>(), sets);
            }
        }
    }

    #[test]
    fn nothing_offered_is_nothing_served() {
        let mut best = BestSets::new(3, 4);
        for quality in [0.0, -0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            best.offer(1, 2, quality);
        }
        assert_eq!(best, BestSets::new(3, 4));
        assert_eq!((best.n_served(), best.quality(1)), (0, None));
        assert!(best.total_quality().to_bits() == 0, "an empty sum is +0");
        assert_eq!(BestSets::new(0, 0).total_quality(), 0.0);
    }
}
