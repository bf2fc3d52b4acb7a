use super::field::Field;
use super::utility::share;
use crate::flow::Selection;
use crate::view::detour;
use rayon::prelude::*;

/// Tours of what worth for what path: what makes one better than another.
///
/// A tour scores (1 - theta) times its worth as a share of that of a reference tour, less theta times its length as a share
/// of that one's.
pub(super) struct TradeOff<'a> {
    field: &'a Field<'a>,
    theta: f64,
    reference: Vec<u32>,
    worth: f64,
    length: f64,
    /// Most sets of a tour.
    n_sets: usize,
    /// Least gain for which a set is added to others.
    least_gain: f64,
    /// The same for the first one: not more than the reference begins with.
    least_first_gain: f64,
}

/// Looks at all sets, each a visit of all pairs of item and set, after which the search ends: a second or two.
const MAX_WORK: usize = 500_000_000;

/// Scores that differ by less may do so by rounding.
const TOLERANCE: f64 = 1e-9;

/// A set to insert into a tour.
struct Insertion {
    set: u32,
    place: usize,
    gain: f64,
    score: f64,
}

impl<'a> TradeOff<'a> {
    /// Tours of up to `n_sets` sets, measured by that through the reference's, which come in the order of their gains.
    pub fn new(field: &'a Field<'a>, theta: f64, reference: &[u32], n_sets: usize, least_gain: f64) -> Self {
        let first_gain = field.values.worth(reference.first().copied());
        let reference = field.tour(reference.to_vec());
        let worth = field.values.worth(reference.iter().copied());
        Self {
            theta,
            worth,
            length: field.length(&reference),
            reference,
            n_sets,
            least_gain,
            least_first_gain: least_gain.min(first_gain),
            field,
        }
    }

    /// A tour of large score: the better of two, one grown set by set and one that begins as the reference, both after sets
    /// were left out, exchanged and added as long as that helped.
    pub fn tour(&self) -> Vec<u32> {
        let [grown, from_reference] =
            [self.field.tour(self.grown()), self.reference.clone()].map(|tour| self.improved(tour));
        if self.score(&from_reference) > self.score(&grown) { from_reference } else { grown }
    }

    fn score(&self, tour: &[u32]) -> f64 {
        self.rate(self.field.values.worth(tour.iter().copied()), self.field.length(tour))
    }

    fn rate(&self, worth: f64, length: f64) -> f64 {
        (1.0 - self.theta) * share(worth, self.worth) - self.theta * share(length, self.length)
    }

    fn grown(&self) -> Vec<u32> {
        let mut tour = Vec::new();
        while let Some(insertion) = self.insertion(&tour) {
            tour.insert(insertion.place, insertion.set);
        }
        tour
    }

    /// The set that adds most to the score where it costs least, the lowest of several; none if none adds anything. The first one is
    /// added even if it is not worth the way.
    fn insertion(&self, tour: &[u32]) -> Option<Insertion> {
        let Field { values, positions, start, ball, .. } = self.field;
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
        let helpful: Vec<Insertion> = all.map(rate).filter(is_helpful).collect();
        helpful.into_iter().reduce(|best, other| if other.score > best.score { other } else { best })
    }

    /// The tour after sets were left out, exchanged or added as long as that helps.
    fn improved(&self, mut tour: Vec<u32>) -> Vec<u32> {
        let mut n_left = MAX_WORK / self.field.values.n_pairs().max(1);
        let mut n_tried = 0;
        // All places in turn, and one past the end, where nothing is left out.
        while n_tried <= tour.len() && n_left > 0 {
            let place = n_left % (tour.len() + 1);
            let other = self.without(&tour, place);
            (n_left, n_tried) = (n_left - 1, n_tried + 1);
            if !other.is_empty() && self.score(&other) > self.score(&tour) + TOLERANCE {
                (tour, n_tried) = (other, 0);
            }
        }
        tour
    }

    /// The tour without the set at this place, if there is one, and with the set that helps most then.
    fn without(&self, tour: &[u32], place: usize) -> Vec<u32> {
        let mut other: Vec<u32> = tour.to_vec();
        if place < other.len() {
            other.remove(place);
        }
        if let Some(insertion) = self.insertion(&other) {
            other.insert(insertion.place, insertion.set);
        }
        self.field.tour(other)
    }
}
