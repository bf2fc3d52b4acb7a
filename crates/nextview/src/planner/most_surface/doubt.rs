use crate::map::{Occupancy, Snapshot};
use crate::planner::Situation;
use crate::prior::SurfaceEstimate;
use glam::IVec3;
use rustc_hash::FxHashMap;

/// A view that shows less than this share of its expectation is a disappointment.
const DISAPPOINTING: f64 = 0.5;

/// The smallest factor on the probabilities of the voxels that a disappointing view was expected to show. One
/// more such view may be worth it once all others are worth less.
const LEAST_FACTOR: f64 = 0.2;

/// Minimum number of expected voxels: fewer prove nothing.
const LEAST_EXPECTED: f64 = 1.0;

/// Minimum probability of a voxel that counts as expected.
const EXPECTED: f32 = 0.05;

/// Doubts from views that showed hardly anything of what was expected. A frame may be empty because the
/// camera was too near, or because the surface is black; its neighbours would be as empty.
///
/// Other views change the map, and that is enough.
#[derive(Clone, Debug, Default)]
pub(super) struct Doubt {
    /// Edge of the voxels, metres; a new size discards all doubts.
    voxel_size: f64,
    /// The factors on the probabilities of voxels, by key.
    factors: FxHashMap<IVec3, f32>,
    expected: Option<Expectation>,
}

/// The expectation of the last plan.
#[derive(Clone, Debug)]
struct Expectation {
    view: usize,
    n_visited: usize,
    n_occupied: usize,
    gain: f64,
    voxels: Vec<IVec3>,
}

impl Doubt {
    /// Returns the doubts after the view taken since the last plan.
    pub fn learned(&self, situation: &Situation<'_>, snapshot: &Snapshot) -> Self {
        let voxel_size = snapshot.lattice().voxel_size();
        if voxel_size != self.voxel_size {
            return Self { voxel_size, ..Self::default() };
        }
        let mut learned = Self { voxel_size, factors: self.factors.clone(), expected: None };
        if let Some((expected, factor)) = self
            .expected
            .as_ref()
            .and_then(|expected| Some((expected, expected.factor(situation, snapshot)?)))
        {
            for key in &expected.voxels {
                *learned.factors.entry(*key).or_insert(1.0) *= factor;
            }
        }
        learned
    }

    /// Lowers the probabilities of an estimate for this snapshot.
    pub fn lower(&self, estimate: &mut SurfaceEstimate, snapshot: &Snapshot) {
        if self.factors.is_empty() {
            return;
        }
        for i in 0..estimate.len() {
            let key = snapshot.block().key(estimate.voxels()[i] as usize);
            if let Some(factor) = self.factors.get(&key) {
                estimate.scale(i, *factor);
            }
        }
    }

    /// Stores what a view is expected to show: `gain` voxels in total, and the probability of each in
    /// `shown`.
    pub fn expect(
        &mut self,
        (view, gain): (usize, f64),
        shown: impl Iterator<Item = (usize, f32)>,
        estimate: &SurfaceEstimate,
        situation: &Situation<'_>,
        snapshot: &Snapshot,
    ) {
        let likely = shown.filter(|(_, p)| *p >= EXPECTED);
        self.expected = Some(Expectation {
            view,
            gain,
            n_visited: situation.visited().len(),
            n_occupied: snapshot.count(Occupancy::Occupied),
            voxels: likely.map(|(i, _)| snapshot.block().key(estimate.voxels()[i] as usize)).collect(),
        });
    }
}

impl Expectation {
    /// The factor on the probabilities of the voxels that the view was expected to show; `None` if other
    /// views were taken since, or if it showed enough.
    fn factor(&self, situation: &Situation<'_>, snapshot: &Snapshot) -> Option<f32> {
        let is_only_one = situation.visited().len() == self.n_visited + 1;
        if !is_only_one || situation.visited().last() != Some(&self.view) || self.gain < LEAST_EXPECTED {
            return None;
        }
        let n_new = snapshot.count(Occupancy::Occupied).saturating_sub(self.n_occupied);
        let share = n_new as f64 / self.gain / DISAPPOINTING;
        (share < 1.0).then_some(share.max(LEAST_FACTOR) as f32)
    }
}
