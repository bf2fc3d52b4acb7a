use super::field::BatchField;
use crate::flow::Selection;
use crate::motion::detour;
use crate::planner::utility::share;
use crate::{Cancel, Cancelled};
use rayon::prelude::*;

/// Compares tours by the value of their views and the length of their path.
///
/// The score of a tour is (1 - theta) times its value relative to a reference tour, less theta times its
/// length relative to that of the reference.
pub(super) struct TradeOff<'a> {
    field: &'a BatchField<'a>,
    theta: f64,
    reference: Vec<u32>,
    value: f64,
    length: f64,
    /// Maximum number of sets of a tour.
    n_sets: usize,
    /// Least gain for which a set is added to others.
    least_gain: f64,
    /// Least gain of the first set: at most the first gain of the reference.
    least_first_gain: f64,
}

/// Pairs of item and set visited over all passes, after which the search ends: a second or two.
const MAX_WORK: usize = 500_000_000;

/// Differences between scores below this may be rounding errors.
const TOLERANCE: f64 = 1e-9;

/// A set to insert into a tour.
struct Insertion {
    set: u32,
    place: usize,
    gain: f64,
    score: f64,
}

impl<'a> TradeOff<'a> {
    /// Compares tours of up to `n_sets` sets with the tour through the sets of the reference, which must be
    /// in the order of their gains.
    pub fn new(
        field: &'a BatchField<'a>,
        theta: f64,
        reference: &[u32],
        n_sets: usize,
        least_gain: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let first_gain = field.values.value_of(reference.first().copied());
        let reference = field.tour(reference.to_vec(), cancel)?;
        let value = field.values.value_of(reference.iter().copied());
        Ok(Self {
            theta,
            value,
            length: field.length(&reference),
            reference,
            n_sets,
            least_gain,
            least_first_gain: least_gain.min(first_gain),
            field,
        })
    }

    /// Returns a tour of large score: the better of one grown set by set and one that begins as the
    /// reference. Both are improved by leaving out, exchanging and adding sets.
    pub fn tour(&self, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
        let grown = self.improved(self.field.tour(self.grown(cancel)?, cancel)?, cancel)?;
        let from_reference = self.improved(self.reference.clone(), cancel)?;
        Ok(if self.score(&from_reference) > self.score(&grown) { from_reference } else { grown })
    }

    fn score(&self, tour: &[u32]) -> f64 {
        self.rate(self.field.values.value_of(tour.iter().copied()), self.field.length(tour))
    }

    fn rate(&self, value: f64, length: f64) -> f64 {
        (1.0 - self.theta) * share(value, self.value) - self.theta * share(length, self.length)
    }

    fn grown(&self, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
        let mut tour = Vec::new();
        while let Some(insertion) = self.insertion(&tour, cancel)? {
            tour.insert(insertion.place, insertion.set);
        }
        Ok(tour)
    }

    /// The set that adds most to the score where it costs least, the lowest number on ties; `None` if none
    /// adds anything. The first one is added even if it does not pay for its path.
    fn insertion(&self, tour: &[u32], cancel: &Cancel) -> Result<Option<Insertion>, Cancelled> {
        let BatchField { values, positions, start, ball, .. } = self.field;
        let (mut selection, route) = (Selection::new(values), self.field.route(tour));
        tour.iter().for_each(|&set| _ = selection.add(set));
        let rate = |set: u32| {
            let gain = selection.gain(set);
            let (place, cost) = detour(*start, &route, positions[set as usize], ball);
            Insertion { set, place, gain, score: self.rate(gain, cost) }
        };
        let is_helpful = |insertion: &Insertion| {
            if tour.is_empty() {
                return insertion.gain > 0.0 && insertion.gain >= self.least_first_gain;
            }
            insertion.score > TOLERANCE && insertion.gain >= self.least_gain
        };
        let all = (0..values.n_sets() as u32).into_par_iter().filter(|_| tour.len() < self.n_sets);
        let rated = all.map(|set| cancel.check().map(|()| rate(set)));
        let rated: Vec<Insertion> = rated.collect::<Result<_, Cancelled>>()?;
        let helpful = rated.into_iter().filter(is_helpful);
        Ok(helpful.reduce(|best, other| if other.score > best.score { other } else { best }))
    }

    /// Leaves out, exchanges or adds sets as long as that improves the tour.
    fn improved(&self, mut tour: Vec<u32>, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
        let mut n_left = MAX_WORK / self.field.values.n_pairs().max(1);
        let mut n_tried = 0;
        // All places in turn, and one past the end, where nothing is left out.
        while n_tried <= tour.len() && n_left > 0 {
            let place = n_left % (tour.len() + 1);
            let other = self.without(&tour, place, cancel)?;
            (n_left, n_tried) = (n_left - 1, n_tried + 1);
            if !other.is_empty() && self.score(&other) > self.score(&tour) + TOLERANCE {
                (tour, n_tried) = (other, 0);
            }
        }
        Ok(tour)
    }

    /// The tour without the set at this place, if any, and with the set that then helps most.
    fn without(&self, tour: &[u32], place: usize, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
        let mut other: Vec<u32> = tour.to_vec();
        if place < other.len() {
            other.remove(place);
        }
        if let Some(insertion) = self.insertion(&other, cancel)? {
            other.insert(insertion.place, insertion.set);
        }
        self.field.tour(other, cancel)
    }
}
