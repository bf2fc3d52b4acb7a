use super::bound::{Bound, earnings, sum};
use super::{Selection, SetValues};

/// Pairs of item and set visited after which the search ends, some 0.2 s.
const MAX_WORK: usize = 100_000_000;

/// What is worth more by less than this share may be so by rounding.
const TOLERANCE: f64 = 1e-9;

/// The best choice that was found, and a bound on all.
pub(super) struct Exact {
    pub sets: Vec<u32>,
    pub bound: f64,
}

/// Looks for a better choice of `n_sets` sets than `known` by branch and bound. If the search comes to its end, the choice is the
/// best there is and the bound is its worth; if not, the bound is what the rest could hold.
///
/// `bound` prices all items; they serve to cut off branches, and to leave out the sets that no better choice holds.
pub(super) fn branch_and_bound(values: &SetValues, n_sets: usize, known: Vec<u32>, bound: &Bound) -> Exact {
    let worth = values.worth(known.iter().copied());
    let mut search = Search { values, prices: &bound.prices, best: known, worth, path: Vec::new(), work: 0 };
    let candidates = search.candidates(n_sets, bound.value);
    let reached = search.explore(&Selection::new(values), &candidates, n_sets);
    Exact { sets: search.best, bound: reached.max(search.worth).min(bound.value.max(search.worth)) }
}

struct Search<'a> {
    values: &'a SetValues,
    prices: &'a [f64],
    best: Vec<u32>,
    worth: f64,
    /// The sets of the selection that is explored.
    path: Vec<u32>,
    work: usize,
}

impl Search<'_> {
    /// The sets that a choice better than the known one may hold: with one that is not among the `n_sets` of largest earnings, the
    /// bound falls by what it earns less than the least of those.
    fn candidates(&mut self, n_sets: usize, bound: f64) -> Vec<u32> {
        let sets: Vec<u32> = (0..self.values.n_sets() as u32).collect();
        self.work += self.values.n_pairs();
        let earned = earnings(self.values, &sets, self.prices);
        let mut sorted: Vec<f64> = earned.iter().map(|(earned, _)| *earned).collect();
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let least = n_sets.checked_sub(1).and_then(|last| sorted.get(last)).copied().unwrap_or(0.0);
        let may_help = |earned: f64| bound - (least - earned).max(0.0) > self.cut();
        earned.into_iter().filter(|(earned, _)| may_help(*earned)).map(|(_, set)| set).collect()
    }

    /// Only what is worth more is better.
    fn cut(&self) -> f64 {
        self.worth * (1.0 + TOLERANCE)
    }

    /// Tries all choices of up to `n` candidates besides the selection. Returns a bound on what those are worth that might be
    /// better than the best; 0 if none is.
    fn explore(&mut self, selection: &Selection<'_>, candidates: &[u32], n: usize) -> f64 {
        let worth = selection.worth();
        self.keep(worth);
        let gains = self.gains(selection, candidates);
        let mut reached: f64 = 0.0;
        for first in 0..gains.len() {
            let rest = &gains[first..];
            let bound = worth + rest.iter().take(n).fold(0.0, |sum, (gain, _)| sum + gain);
            if n == 0 || bound <= self.cut() {
                break;
            }
            if self.work > MAX_WORK {
                return reached.max(bound);
            }
            let with_first = self.with(selection, rest[0].1);
            let others: Vec<u32> = rest[1..].iter().map(|(_, set)| *set).collect();
            if self.priced_bound(&with_first, &others, n - 1) > self.cut() {
                self.path.push(rest[0].1);
                reached = reached.max(self.explore(&with_first, &others, n - 1));
                self.path.pop();
            }
        }
        reached
    }

    fn keep(&mut self, worth: f64) {
        if worth > self.cut() {
            (self.worth, self.best) = (worth, self.path.clone());
        }
    }

    /// The candidates that gain anything, the best first.
    fn gains(&mut self, selection: &Selection<'_>, candidates: &[u32]) -> Vec<(f64, u32)> {
        let mut gains: Vec<(f64, u32)> = candidates
            .iter()
            .map(|&set| (selection.gain(set), set))
            .filter(|(gain, _)| *gain > 0.0)
            .collect();
        self.count(candidates);
        gains.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        gains
    }

    fn with<'s>(&mut self, selection: &Selection<'s>, set: u32) -> Selection<'s> {
        let mut with = selection.clone();
        with.add(set);
        self.work += self.values.n_items();
        with
    }

    /// A bound on what the selection and `n` of the candidates are worth: each item is granted its price, or what it has if that
    /// is more.
    fn priced_bound(&mut self, selection: &Selection<'_>, candidates: &[u32], n: usize) -> f64 {
        let prices: Vec<f64> = self
            .prices
            .iter()
            .zip(selection.served())
            .map(|(price, &served)| price.max(served as f64))
            .collect();
        self.count(candidates);
        let mut earned = earnings(self.values, candidates, &prices);
        earned.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        sum(&prices) + earned.iter().take(n).fold(0.0, |sum, (earned, _)| sum + earned)
    }

    fn count(&mut self, candidates: &[u32]) {
        let pairs: usize = candidates.iter().map(|&set| self.values.row(set).len()).sum();
        self.work += pairs + self.values.n_items();
    }
}
