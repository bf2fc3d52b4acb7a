//! The two planners that bound all others: random views, and the clairvoyant planner, which knows the object.

use crate::truth::TrueVisibility;
use nextview::Error;
use nextview::geometry::random::Random;
use nextview::planner::{Choice, Plan, Situation, ViewPlanner};
use std::sync::Arc;

/// Takes the view that truly sees the most new object voxels: greedy on the true visibility, which only a
/// simulation knows.
#[derive(Clone, Debug)]
pub struct Clairvoyant {
    truth: Arc<TrueVisibility>,
}

impl Clairvoyant {
    /// Creates a planner with this visibility, which must be that of the candidates it chooses from.
    pub fn new(truth: Arc<TrueVisibility>) -> Self {
        Self { truth }
    }
}

impl ViewPlanner for Clairvoyant {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let can_go = |view: usize| situation.can_go(view);
        let next = next_clairvoyant(&self.truth, situation.visited(), can_go);
        let choice = next.map(|(view, n_new)| Choice::new(view, n_new as f64));
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// The view that adds the most object voxels to those seen from the visited views, and their number; `None`
/// if no view adds any.
fn next_clairvoyant(
    truth: &TrueVisibility,
    visited: &[usize],
    can_go: impl Fn(usize) -> bool,
) -> Option<(usize, usize)> {
    let mut covered = truth.seen(visited.first().copied().unwrap_or(0)).clone();
    covered.clear();
    visited.iter().for_each(|&view| covered.union_with(truth.seen(view)));
    let n_new = |view: usize| truth.seen(view).difference_count(&covered);
    let best = (0..truth.n_views())
        .filter(|&view| can_go(view))
        .map(|view| (view, n_new(view)))
        .max_by_key(|&(view, n)| (n, std::cmp::Reverse(view)));
    best.filter(|&(_, n)| n > 0)
}

/// Returns the clairvoyant planner's coverage after each of `n` views, starting with `first_view`.
pub fn clairvoyant_curve(truth: &TrueVisibility, first_view: usize, n: usize) -> Vec<f64> {
    let mut views = vec![first_view];
    while views.len() < n {
        match next_clairvoyant(truth, &views, |_| true) {
            Some((view, _)) => views.push(view),
            None => break,
        }
    }
    extended(truth.coverage_curve(&views), n)
}

/// Coverage of random views, over many sequences from the same first view.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomCurve {
    /// Mean after each view.
    pub mean: Vec<f64>,
    /// The 5 % quantile after each view.
    pub low: Vec<f64>,
    /// The 95 % quantile after each view.
    pub high: Vec<f64>,
}

impl RandomCurve {
    /// Number of sequences: the mean is known to about a tenth of the spread.
    pub const N_DRAWS: usize = 200;

    /// Draws the sequences: distinct views, uniform among the candidates. The same seed gives the same draws.
    /// They are independent of the draws of [`RandomViews`](nextview::planner::RandomViews) with any seed,
    /// even the same one.
    pub fn new(truth: &TrueVisibility, first_view: usize, n: usize, seed: u64) -> Self {
        let curve = |draw| {
            let views = draw_views(truth.n_views(), first_view, n, seed, draw);
            extended(truth.coverage_curve(&views), n)
        };
        let curves: Vec<Vec<f64>> = (0..Self::N_DRAWS as u64).map(curve).collect();
        let quantile = |q: f64| {
            let at = |step: usize| {
                let mut values: Vec<f64> = curves.iter().map(|curve| curve[step]).collect();
                values.sort_by(f64::total_cmp);
                values[(q * (values.len() - 1) as f64).round() as usize]
            };
            (0..n).map(at).collect()
        };
        let mean = |step: usize| curves.iter().map(|curve| curve[step]).sum::<f64>() / curves.len() as f64;
        Self { mean: (0..n).map(mean).collect(), low: quantile(0.05), high: quantile(0.95) }
    }
}

/// First of the random streams, one per sequence. The random planner uses the streams from 1 up to its number
/// of views.
const FIRST_STREAM: u64 = 1 << 32;

/// The random sequence with this number: distinct views, starting with the given one.
fn draw_views(n_candidates: usize, first_view: usize, n: usize, seed: u64, draw: u64) -> Vec<usize> {
    let mut random = Random::new(seed, FIRST_STREAM + draw);
    let mut open: Vec<usize> = (0..n_candidates).filter(|&view| view != first_view).collect();
    let mut views = vec![first_view];
    while views.len() < n && !open.is_empty() {
        views.push(open.swap_remove(random.index(open.len())));
    }
    views
}

/// Extends a curve that ended early with its last value.
pub fn extended(mut curve: Vec<f64>, n: usize) -> Vec<f64> {
    let last = curve.last().copied().unwrap_or(0.0);
    curve.resize(n, last);
    curve
}

/// Returns the skill: the area under a coverage curve on a scale from random views (0) to clairvoyant (1).
/// `None` if the two do not differ. All curves have the same length.
pub fn skill(curve: &[f64], random: &[f64], clairvoyant: &[f64]) -> Option<f64> {
    assert!(curve.len() == random.len() && random.len() == clairvoyant.len(), "curves of equal length");
    let area = |curve: &[f64]| curve.iter().sum::<f64>();
    let range = area(clairvoyant) - area(random);
    (range.abs() > 1e-12).then(|| (area(curve) - area(random)) / range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixedbitset::FixedBitSet;

    #[test]
    fn skill_is_zero_for_random_and_one_for_clairvoyant() {
        let (random, clairvoyant) = ([0.2, 0.4, 0.5], [0.2, 0.7, 0.9]);
        assert_eq!(skill(&random, &random, &clairvoyant), Some(0.0));
        assert_eq!(skill(&clairvoyant, &random, &clairvoyant), Some(1.0));
        assert_eq!(skill(&random, &random, &random), None);
        assert!(skill(&[0.2, 0.3, 0.4], &random, &clairvoyant).unwrap() < 0.0);
    }

    /// Areas 1.25, 2 and 1.75 by hand. The curve starts and ends with the clairvoyant one, so every view
    /// counts.
    #[test]
    fn skill_is_of_the_area_under_the_whole_curve() {
        let (random, clairvoyant) = ([0.25, 0.5, 0.5], [0.25, 0.75, 1.0]);
        assert_eq!(skill(&[0.25, 0.5, 1.0], &random, &clairvoyant), Some(0.5 / 0.75));
        assert_eq!(skill(&[0.25, 0.25, 0.75], &random, &clairvoyant), Some(0.0));
        assert_eq!(skill(&[0.25, 1.0, 1.0], &random, &clairvoyant), Some(1.0 / 0.75));
        assert_eq!(skill(&[0.25, 0.25, 0.25], &random, &clairvoyant), Some(-0.5 / 0.75));
    }

    /// Four views of eight voxels.
    fn truth() -> TrueVisibility {
        let seen = |voxels: &[usize]| voxels.iter().copied().collect::<FixedBitSet>();
        let views = [seen(&[0, 1]), seen(&[2]), seen(&[0, 1, 2, 3, 4]), seen(&[2, 3, 5, 6, 7])];
        TrueVisibility::of_seen(
            views
                .into_iter()
                .map(|mut set| {
                    set.grow(8);
                    set
                })
                .collect(),
        )
        .unwrap()
    }

    /// By hand: from view 0, view 3 adds five voxels and view 2 three; then view 2 adds the last one.
    #[test]
    fn the_clairvoyant_curve_is_greedy_and_stays_where_nothing_is_left() {
        let truth = truth();
        assert_eq!(clairvoyant_curve(&truth, 0, 5), [0.25, 0.875, 1.0, 1.0, 1.0]);
        // Views 2 and 3 then add four voxels each, and the first of them is taken.
        assert_eq!(clairvoyant_curve(&truth, 1, 3), [0.125, 0.625, 1.0]);
        assert_eq!(next_clairvoyant(&truth, &[0], |view| view != 3), Some((2, 3)));
        assert_eq!(next_clairvoyant(&truth, &[2, 3], |_| true), None);
    }

    /// After view 0, the second view is 1, 2 or 3, whose curves reach 3, 5 or 7 of eight voxels; the last
    /// view shows the rest.
    #[test]
    fn the_random_curve_is_the_mean_and_has_the_quantiles_of_all_sequences() {
        let RandomCurve { mean, low, high } = RandomCurve::new(&truth(), 0, 5, 0);
        assert_eq!([low[1], high[1]], [0.375, 0.875]);
        assert!((mean[1] - 5.0 / 8.0).abs() < 0.04, "{mean:?}: a standard deviation of 0.014 was expected");
        assert_eq!([mean[0], low[0], high[0]], [0.25; 3]);
        assert_eq!([mean[3], low[3], high[3]], [1.0; 3], "all views were taken");
        assert_eq!((mean.len(), low.len(), high.len()), (5, 5, 5));
    }

    #[test]
    fn random_sequences_are_distinct_views_from_the_first_on() {
        let mut views = draw_views(20, 7, 20, 3, 5);
        assert_eq!(views[0], 7);
        views.sort_unstable();
        assert_eq!(views, (0..20).collect::<Vec<_>>());
        assert_eq!(draw_views(3, 0, 10, 1, 0).len(), 3, "no more than there are");
    }

    /// The second views of a seed's sequences agree with those of random planners of any seed as often as
    /// independent draws do.
    #[test]
    fn baseline_and_random_planner_are_independent() {
        let n = 50;
        let second_of_planner = |seed: u64| 1 + Random::new(seed, 1).index(n - 1);
        let (mut n_equal, mut n_all) = (0, 0);
        for seed in 0..40 {
            for draw in 0..RandomCurve::N_DRAWS as u64 {
                let second = draw_views(n, 0, 2, seed, draw)[1];
                n_equal += usize::from(second == second_of_planner(draw));
                n_equal += usize::from(second == second_of_planner(seed));
                n_all += 2;
            }
        }
        // One of 49, with a standard deviation of about 18 in 16000.
        let expected = n_all as f64 / (n - 1) as f64;
        assert!((n_equal as f64 - expected).abs() < 80.0, "{n_equal} of {n_all}");
    }

    #[test]
    fn every_seed_and_draw_has_a_sequence_of_its_own() {
        let sequence = |seed, draw| draw_views(1000, 0, 5, seed, draw);
        assert_eq!(sequence(3, 7), sequence(3, 7));
        assert!(sequence(3, 7) != sequence(3, 8) && sequence(3, 7) != sequence(4, 7));
    }
}
