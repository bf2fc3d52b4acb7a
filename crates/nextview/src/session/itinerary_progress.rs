use crate::geometry::{Lattice, VoxelBlock};
use crate::map::{Occupancy, Snapshot};
use crate::planner::{Choice, Itinerary, Leg};
use std::collections::VecDeque;

/// The itinerary followed by a session, with the measured and expected voxels so far.
#[derive(Debug, Default)]
pub(super) struct ItineraryProgress {
    /// The current leg first.
    legs: VecDeque<Leg>,
    tolerance: f64,
    /// The decision for the current leg was discarded: the leg has not started yet.
    is_discarded: bool,
    /// The map when the current leg began.
    departure: Option<Departure>,
    /// Newly occupied voxels, measured and expected; each leg counts twice as much as the one before.
    measured: f64,
    expected: f64,
}

#[derive(Debug)]
struct Departure {
    lattice: Lattice,
    block: VoxelBlock,
    n_occupied: usize,
}

impl ItineraryProgress {
    /// Switches to another itinerary, or to none.
    pub fn follow(&mut self, itinerary: Option<Itinerary>) {
        let Itinerary { legs, tolerance } = itinerary.unwrap_or_default();
        (self.legs, self.tolerance) = (legs.into(), tolerance);
        self.is_discarded = false;
    }

    /// Starts the first leg, if there is one.
    pub fn depart(&mut self, snapshot: &Snapshot) {
        self.departure = (!self.legs.is_empty()).then(|| Departure::new(snapshot));
    }

    /// Returns the next view of the itinerary; `None` if it is finished, or abandoned because the map was
    /// rebuilt or the last leg showed less than expected.
    pub fn next(&mut self, snapshot: &Snapshot) -> Option<Choice> {
        if std::mem::take(&mut self.is_discarded) {
            return self.legs.front().map(|leg| leg.choice.clone());
        }
        let leg = self.legs.pop_front()?;
        let measured = self.departure.take().and_then(|departure| departure.n_newly_occupied(snapshot));
        if !measured.is_some_and(|measured| self.is_as_expected(leg.expected, measured)) {
            self.legs.clear();
        }
        self.legs.front().map(|leg| leg.choice.clone())
    }

    /// Returns the legs after the current one.
    pub fn rest(&self) -> impl Iterator<Item = &Leg> {
        self.legs.iter().skip(1)
    }

    /// Drops the itinerary if it leads to a view that is given up. Otherwise keeps it, and also the current
    /// leg if the decision for it is discarded.
    pub fn skip(&mut self, is_given_up: impl Fn(usize) -> bool, is_discarded: bool) {
        if self.legs.iter().any(|leg| is_given_up(leg.choice.view)) {
            self.legs.clear();
        }
        self.is_discarded = is_discarded && !self.legs.is_empty();
    }

    /// Compares a leg with the ratio of measured to expected voxels on earlier legs. The first leg sets the
    /// ratio, unless it showed nothing.
    fn is_as_expected(&mut self, expected: f64, measured: f64) -> bool {
        let known = if self.expected > 0.0 { self.measured / self.expected } else { measured / expected };
        let expected_now = known * expected;
        self.measured = 0.5 * self.measured + measured;
        self.expected = 0.5 * self.expected + expected;
        measured > 0.0 && (measured - expected_now).abs() <= self.tolerance * expected_now
    }
}

impl Departure {
    fn new(snapshot: &Snapshot) -> Self {
        let n_occupied = snapshot.count(Occupancy::Occupied);
        Self { lattice: snapshot.lattice(), block: snapshot.block(), n_occupied }
    }

    /// `None` if the box or the voxel size of the map has changed.
    fn n_newly_occupied(&self, snapshot: &Snapshot) -> Option<f64> {
        let is_same = self.lattice == snapshot.lattice() && self.block == snapshot.block();
        is_same.then(|| snapshot.count(Occupancy::Occupied).saturating_sub(self.n_occupied) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::LogOdds;
    use glam::{IVec3, UVec3};

    /// A box with this number of occupied voxels.
    fn snapshot(n_occupied: usize, voxel_size: f64) -> Snapshot {
        let block = VoxelBlock::new(IVec3::ZERO, UVec3::splat(20)).unwrap();
        let is_occupied = |key| block.index(key).is_some_and(|index| index < n_occupied);
        Snapshot::from_fn(Lattice::new(voxel_size).unwrap(), block, |key| {
            is_occupied(key).then_some(LogOdds(1.0))
        })
    }

    /// Views 0, 1, 2, ... with these expected voxels.
    fn itinerary(expected: &[f64]) -> Itinerary {
        let leg = |(view, &expected): (usize, &f64)| Leg { choice: Choice::new(view, 0.0), expected };
        Itinerary { legs: expected.iter().enumerate().map(leg).collect(), tolerance: 0.5 }
    }

    /// The views visited without replanning if the legs show these numbers of new voxels.
    fn followed(progress: &mut ItineraryProgress, expected: &[f64], measured: &[usize]) -> Vec<usize> {
        let (mut n_occupied, mut views) = (100, Vec::new());
        progress.follow(Some(itinerary(expected)));
        for n_new in measured {
            progress.depart(&snapshot(n_occupied, 0.01));
            n_occupied += n_new;
            let Some(choice) = progress.next(&snapshot(n_occupied, 0.01)) else { break };
            views.push(choice.view);
        }
        views
    }

    #[test]
    fn an_itinerary_is_followed_while_it_keeps_its_promise() {
        let of = |measured: &[usize]| {
            followed(&mut ItineraryProgress::default(), &[40.0, 30.0, 20.0, 10.0], measured)
        };
        assert_eq!(of(&[200, 150, 100, 50]), [1, 2, 3]);
        assert_eq!(of(&[200, 140, 110, 50]), [1, 2, 3], "about as much");
        assert_eq!(of(&[200, 70, 100, 50]), [1], "less");
        assert_eq!(of(&[200, 240, 100, 50]), [1], "more");
        assert_eq!(of(&[0, 150, 100, 50]), [0; 0], "nothing");
    }

    #[test]
    fn the_next_itinerary_is_measured_by_the_last() {
        let mut progress = ItineraryProgress::default();
        assert_eq!(followed(&mut progress, &[40.0, 30.0], &[200, 150]), [1]);
        assert_eq!(followed(&mut progress, &[40.0, 30.0], &[90, 150]), [0; 0]);
        assert_eq!(followed(&mut progress, &[40.0, 30.0], &[110, 150]), [1]);
    }

    #[test]
    fn another_map_ends_it() {
        let mut progress = ItineraryProgress::default();
        progress.follow(Some(itinerary(&[1.0, 1.0])));
        progress.depart(&snapshot(10, 0.02));
        assert_eq!(progress.next(&snapshot(20, 0.01)), None);
        assert_eq!(progress.next(&snapshot(20, 0.01)), None);
    }

    #[test]
    fn without_an_itinerary_there_is_no_next_view() {
        let mut progress = ItineraryProgress::default();
        progress.follow(None);
        progress.depart(&snapshot(10, 0.01));
        assert_eq!(progress.next(&snapshot(20, 0.01)), None);
    }
}
