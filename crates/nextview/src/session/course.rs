use crate::geometry::{Lattice, VoxelBlock};
use crate::map::{Occupancy, Snapshot};
use crate::planner::{Choice, Itinerary, Leg};
use std::collections::VecDeque;

/// The itinerary that a session is on, and what was seen on the way so far beside what was expected.
#[derive(Debug, Default)]
pub(super) struct Course {
    /// The leg under way first.
    legs: VecDeque<Leg>,
    tolerance: f64,
    /// The map when the leg under way began.
    departure: Option<Departure>,
    /// Newly occupied voxels, measured and expected; those of each further leg count twice as much as the last.
    measured: f64,
    expected: f64,
}

#[derive(Debug)]
struct Departure {
    lattice: Lattice,
    block: VoxelBlock,
    n_occupied: usize,
}

impl Course {
    /// Goes over to another itinerary, or to none.
    pub fn follow(&mut self, itinerary: Option<Itinerary>) {
        let Itinerary { legs, tolerance } = itinerary.unwrap_or_default();
        (self.legs, self.tolerance) = (legs.into(), tolerance);
    }

    /// Sets off on the first leg, if there is one.
    pub fn depart(&mut self, snapshot: &Snapshot) {
        self.departure = (!self.legs.is_empty()).then(|| Departure::new(snapshot));
    }

    /// The next view of the itinerary; none if that is done, or not to be followed any longer because the map was made anew
    /// or the last leg showed something else than expected.
    pub fn next(&mut self, snapshot: &Snapshot) -> Option<Choice> {
        let leg = self.legs.pop_front()?;
        let measured = self.departure.take().and_then(|departure| departure.n_newly_occupied(snapshot));
        if !measured.is_some_and(|measured| self.is_as_expected(leg.expected, measured)) {
            self.legs.clear();
        }
        self.legs.front().map(|leg| leg.choice)
    }

    /// Compares with what the legs before showed of what was expected of them. The first leg ever sets the measure, unless it
    /// showed nothing at all.
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

    /// None if the map has another box or voxel size by now.
    fn n_newly_occupied(&self, snapshot: &Snapshot) -> Option<f64> {
        let is_same = self.lattice == snapshot.lattice() && self.block == snapshot.block();
        is_same.then(|| snapshot.count(Occupancy::Occupied).saturating_sub(self.n_occupied) as f64)
    }
}
