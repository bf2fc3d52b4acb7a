//! Times of the flow on made-up problems: `cargo run --release --example flow_timing`.
//!
//! Items and sets are directions on the sphere. A set offers an item its best quality if the two are close, with some
//! chance, and offers it less a few times more.

use nextview::flow::{BestSets, Incidence, fewest_sets};
use nextview::geometry::{random::Random, sphere::fibonacci};
use std::time::Instant;

/// Items, sets, offers per item and set, cosine of the reach of a set, chance that it reaches.
const PROBLEMS: [(usize, usize, usize, f64, f64); 7] = [
    (938, 5000, 2, 0.5, 0.008),
    (938, 5000, 2, 0.9, 0.2),
    (5_000, 5000, 2, 0.9, 0.12),
    (20_000, 5000, 1, 0.5, 0.9),
    (60_000, 5000, 1, 0.0, 0.5),
    (60_000, 5000, 1, 0.0, 1.0),
    (1_000_000, 500, 1, 0.95, 0.9),
];

fn main() {
    println!("  items  sets     offers     ties  offer ms  ns each  merge ms  cover ms  chosen");
    for (n_items, n_sets, repeats, reach, chance) in PROBLEMS {
        let start = Instant::now();
        let mut best = offers(n_items, n_sets, repeats, reach, chance);
        let offered = start.elapsed();
        let start = Instant::now();
        best.merge(best.clone());
        let merged = start.elapsed();
        let start = Instant::now();
        let sets = fewest_sets(best.candidates());
        let covered = start.elapsed();
        let n_offers = n_items * n_sets * repeats;
        println!(
            "{n_items:>7} {n_sets:>5} {n_offers:>10} {:>8} {:>9.1} {:>8.2} {:>9.1} {:>9.1} {:>7}",
            n_ties(best.candidates()),
            offered.as_secs_f64() * 1e3,
            offered.as_secs_f64() * 1e9 / n_offers as f64,
            merged.as_secs_f64() * 1e3,
            covered.as_secs_f64() * 1e3,
            sets.len(),
        );
    }
}

/// All offers in the order in which a planner makes them: set by set.
fn offers(n_items: usize, n_sets: usize, repeats: usize, reach: f64, chance: f64) -> BestSets {
    let items: Vec<_> = (0..n_items).map(|i| fibonacci(i, n_items)).collect();
    let mut random = Random::new(1, 0);
    let mut best = BestSets::new(n_items, n_sets);
    for set in 0..n_sets {
        let direction = fibonacci(set * 1237 % n_sets, n_sets);
        for (item, position) in items.iter().enumerate() {
            let close = position.dot(direction);
            let reached = close > reach && (chance >= 1.0 || random.unit() < chance);
            let quality = if reached { 0.5 } else { 0.3 + 0.1 * close };
            (0..repeats).for_each(|_| best.offer(item, set as u32, quality));
        }
    }
    best
}

fn n_ties(candidates: &Incidence) -> usize {
    (0..candidates.n_rows()).map(|item| candidates.row_len(item)).sum()
}
