use crate::flow::{Selection, SetValues};
use crate::motion::{KeepOut, tour_length, tour_unless};
use crate::planner::Situation;
use crate::{Cancel, Cancelled};
use glam::DVec3;

/// The sets from which a batch is chosen: one for each open view, in the same order.
pub(super) struct BatchField<'a> {
    pub values: &'a SetValues,
    /// Value of all sets together.
    pub total: f64,
    /// The camera position of each set.
    pub positions: Vec<DVec3>,
    /// Where the camera is.
    pub start: Option<DVec3>,
    /// The ball around the box.
    pub ball: KeepOut,
}

impl<'a> BatchField<'a> {
    pub fn new(situation: &Situation<'_>, open: &[usize], values: &'a SetValues) -> Result<Self, Cancelled> {
        let mut all = Selection::new(values);
        for set in 0..values.n_sets() as u32 {
            situation.cancel().check()?;
            all.add(set);
        }
        let bounds = situation.snapshot().lattice().bounds(&situation.snapshot().block());
        Ok(Self {
            values,
            total: all.value(),
            positions: open.iter().map(|&view| situation.views().pose(view).translation()).collect(),
            start: situation.camera_position(),
            ball: KeepOut::around(&bounds, 0.0).expect("a block of voxels is a finite box"),
        })
    }

    pub fn route(&self, sets: &[u32]) -> Vec<DVec3> {
        sets.iter().map(|&set| self.positions[set as usize]).collect()
    }

    /// Returns the sets in the order of a short tour, independent of the given order.
    pub fn tour(&self, mut sets: Vec<u32>, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
        sets.sort_unstable();
        let order = tour_unless(self.start, &self.route(&sets), &self.ball, cancel)?;
        Ok(order.into_iter().map(|i| sets[i]).collect())
    }

    pub fn length(&self, tour: &[u32]) -> f64 {
        tour_length(self.start, self.route(tour), &self.ball)
    }
}
