//! The explicit flow network of the paper, small enough to solve in other ways.

use nextview::flow::BestSets;
use proptest::prelude::*;

/// Items → channels → sets.
#[derive(Clone, Debug)]
pub struct Network {
    pub n_items: usize,
    pub n_sets: usize,
    /// Item, channel, quality.
    pub edges: Vec<(usize, usize, f64)>,
    pub sets_of_channel: Vec<Vec<u32>>,
}

impl Network {
    /// Offers all of it, set by set.
    pub fn best_sets(&self) -> BestSets {
        let mut best = BestSets::new(self.n_items, self.n_sets);
        for set in 0..self.n_sets as u32 {
            for &(item, channel, quality) in &self.edges {
                if self.sets_of_channel[channel].contains(&set) {
                    best.offer(item, set, quality);
                }
            }
        }
        best
    }

    /// The quality and the set of each way to serve an item.
    pub fn options(&self, item: usize) -> Vec<(f64, u32)> {
        let edges = self.edges.iter().filter(|edge| edge.0 == item);
        edges.flat_map(|edge| self.sets_of_channel[edge.1].iter().map(|&set| (edge.2, set))).collect()
    }
}

/// Networks of up to `n_items` items, channels and `n_sets` sets. The qualities are few and their sums exact,
/// so that ties are common.
pub fn networks(n_items: usize, n_channels: usize, n_sets: usize) -> impl Strategy<Value = Network> {
    (1..=n_items, 1..=n_channels, 1..=n_sets).prop_flat_map(|(n_items, n_channels, n_sets)| {
        let quality = (1_u32..5).prop_map(|q| q as f64 / 4.0);
        let edges = prop::collection::vec((0..n_items, 0..n_channels, quality), 0..3 * n_items);
        let sets = prop::collection::btree_set(0..n_sets as u32, 0..=n_sets.min(3));
        let sets_of_channel = prop::collection::vec(sets.prop_map(Vec::from_iter), n_channels);
        (edges, sets_of_channel).prop_map(move |(edges, sets_of_channel)| Network {
            n_items,
            n_sets,
            edges,
            sets_of_channel,
        })
    })
}
