use super::bound::{Bound, earnings, sum};
use super::{Selection, SetValues};
use crate::{Cancel, Cancelled};

/// Pairs of item and set visited after which the search ends, about 0.2 s.
const MAX_WORK: usize = 100_000_000;

/// Relative differences below this may be rounding errors.
const TOLERANCE: f64 = 1e-9;

/// The best choice found, and a bound on the value of every choice.
pub(super) struct Exact {
    pub sets: Vec<u32>,
    pub bound: f64,
}

/// Looks for a better choice of `n_sets` sets than `known` by branch and bound. If the search finishes, the
/// choice is optimal and the bound is its value; otherwise the bound also covers the choices not searched.
///
/// `bound` prices all items; the prices cut off branches and rule out sets that no better choice holds.
pub(super) fn branch_and_bound(
    values: &SetValues,
    n_sets: usize,
    known: Vec<u32>,
    bound: &Bound,
    cancel: &Cancel,
) -> Result<Exact, Cancelled> {
    let value = values.value_of(known.iter().copied());
    let prices = &bound.prices;
    let mut search = ExactSearch { values, prices, best: known, value, path: Vec::new(), work: 0, cancel };
    let candidates = search.candidates(n_sets, bound.value)?;
    let reached = search.explore(&Selection::new(values), &candidates, n_sets)?;
    Ok(Exact { sets: search.best, bound: reached.max(search.value).min(bound.value.max(search.value)) })
}

struct ExactSearch<'a> {
    values: &'a SetValues,
    prices: &'a [f64],
    best: Vec<u32>,
    value: f64,
    /// The sets of the selection being explored.
    path: Vec<u32>,
    work: usize,
    cancel: &'a Cancel,
}

impl ExactSearch<'_> {
    /// The sets that may be part of a selection better than the known one. Choosing a set that is not among
    /// the `n_sets` that earn most lowers the bound by the difference between its earnings and the least of
    /// theirs.
    fn candidates(&mut self, n_sets: usize, bound: f64) -> Result<Vec<u32>, Cancelled> {
        let sets: Vec<u32> = (0..self.values.n_sets() as u32).collect();
        self.work += self.values.n_pairs();
        let earned = earnings(self.values, &sets, self.prices, self.cancel)?;
        let mut sorted: Vec<f64> = earned.iter().map(|(earned, _)| *earned).collect();
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let least = n_sets.checked_sub(1).and_then(|last| sorted.get(last)).copied().unwrap_or(0.0);
        let may_help = |earned: f64| bound - (least - earned).max(0.0) > self.cut();
        Ok(earned.into_iter().filter(|(earned, _)| may_help(*earned)).map(|(_, set)| set).collect())
    }

    /// A selection is better only if its value is larger than this.
    fn cut(&self) -> f64 {
        self.value * (1.0 + TOLERANCE)
    }

    /// Tries all selections of up to `n` candidates in addition to the selection. Returns a bound on the
    /// value of those left unexplored because the work was used up; 0 if there are none.
    fn explore(&mut self, selection: &Selection<'_>, candidates: &[u32], n: usize) -> Result<f64, Cancelled> {
        let value = selection.value();
        self.keep(value);
        let gains = self.gains(selection, candidates)?;
        let mut reached: f64 = 0.0;
        for first in 0..gains.len() {
            let rest = &gains[first..];
            let bound = value + rest.iter().take(n).fold(0.0, |sum, (gain, _)| sum + gain);
            if n == 0 || bound <= self.cut() {
                break;
            }
            if self.work > MAX_WORK {
                return Ok(reached.max(bound));
            }
            let with_first = self.with(selection, rest[0].1);
            let others: Vec<u32> = rest[1..].iter().map(|(_, set)| *set).collect();
            if self.priced_bound(&with_first, &others, n - 1)? > self.cut() {
                self.path.push(rest[0].1);
                reached = reached.max(self.explore(&with_first, &others, n - 1)?);
                self.path.pop();
            }
        }
        Ok(reached)
    }

    fn keep(&mut self, value: f64) {
        if value > self.cut() {
            (self.value, self.best) = (value, self.path.clone());
        }
    }

    /// The candidates that gain anything, the best first.
    fn gains(&mut self, selection: &Selection<'_>, candidates: &[u32]) -> Result<Vec<(f64, u32)>, Cancelled> {
        let mut gains = Vec::new();
        for &set in candidates {
            self.cancel.check()?;
            gains.push((selection.gain(set), set));
        }
        gains.retain(|(gain, _)| *gain > 0.0);
        self.count(candidates);
        gains.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        Ok(gains)
    }

    fn with<'s>(&mut self, selection: &Selection<'s>, set: u32) -> Selection<'s> {
        let mut with = selection.clone();
        with.add(set);
        self.work += self.values.n_items();
        with
    }

    /// A bound on the value of the selection and `n` of the candidates: each item is granted its price, or
    /// its present value if that is larger.
    fn priced_bound(
        &mut self,
        selection: &Selection<'_>,
        candidates: &[u32],
        n: usize,
    ) -> Result<f64, Cancelled> {
        let prices: Vec<f64> = self
            .prices
            .iter()
            .zip(selection.served())
            .map(|(price, &served)| price.max(served as f64))
            .collect();
        self.count(candidates);
        let mut earned = earnings(self.values, candidates, &prices, self.cancel)?;
        earned.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        Ok(sum(&prices) + earned.iter().take(n).fold(0.0, |sum, (earned, _)| sum + earned))
    }

    fn count(&mut self, candidates: &[u32]) {
        let pairs: usize = candidates.iter().map(|&set| self.values.row(set).len()).sum();
        self.work += pairs + self.values.n_items();
    }
}
