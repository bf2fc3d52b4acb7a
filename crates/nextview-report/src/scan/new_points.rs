use super::scan_copy::ScanCopy;
use glam::{IVec3, Vec3};
use std::collections::{BTreeMap, HashSet};

/// The new measured points of each frame of the model, distinguished by the cells of the final model. Those
/// of a scan before the object was turned are known from the first step on.
#[derive(Default)]
pub(super) struct NewPoints {
    known: HashSet<IVec3>,
    n_frames: usize,
    /// For each step; world frame, metres.
    by_step: BTreeMap<usize, Vec<Vec3>>,
}

impl NewPoints {
    /// Adds the new frames. Box and poses must be unchanged.
    pub fn update(&mut self, scan: &ScanCopy) {
        let Some((bounds, cell)) = scan.place else { return };
        for (frame, step_idx, _) in scan.model_views().skip(self.n_frames) {
            let points = frame.points_in(bounds).map(|p| ((p / cell).floor().as_ivec3(), p.as_vec3()));
            let new = points.filter(|(key, _)| self.known.insert(*key)).map(|(_, point)| point);
            self.by_step.entry(step_idx.unwrap_or(0)).or_default().extend(new);
            self.n_frames += 1;
        }
    }

    /// The new points of a step; empty if its frame is not in the map.
    pub fn of_step(&self, step_idx: usize) -> &[Vec3] {
        self.by_step.get(&step_idx).map_or(&[], Vec::as_slice)
    }
}
