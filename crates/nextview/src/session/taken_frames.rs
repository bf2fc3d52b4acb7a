use super::seen_cells::SeenCells;
use crate::geometry::{Aabb, Plane, Pose};
use crate::registration::Registration;
use crate::sensor::Frame;

/// A frame that registration set aside: it could not be aligned and is in neither map nor model.
#[derive(Clone, Debug)]
pub struct SetAside {
    /// Number of the frame among all observed frames, from 0.
    pub number: usize,
    /// The frame in the given pose.
    pub frame: Frame,
    /// The last attempt to align it.
    pub registration: Registration,
}

/// All frames observed so far.
#[derive(Clone, Debug, Default)]
pub(super) struct TakenFrames {
    /// The frames in the map: first those of the placement before, then the others in the order in which they
    /// entered.
    pub mapped: Vec<Frame>,
    /// Number of mapped frames of the placement before.
    pub n_earlier: usize,
    /// The number of each mapped frame of this placement among all observed frames.
    pub numbers: Vec<usize>,
    /// The frames not in the map, oldest first.
    pub set_aside: Vec<SetAside>,
    /// The camera poses by frame number: as mapped, or as given if set aside.
    pub places: Vec<Pose>,
    /// The given pose of each frame, by number.
    pub given: Vec<Pose>,
}

/// Alignment is given up only if at least this many frames are set aside: later frames may still link fewer.
const MANY_SET_ASIDE: usize = 5;

impl TakenFrames {
    /// Returns the mapped frames of this placement.
    pub fn of_now(&self) -> &[Frame] {
        &self.mapped[self.n_earlier..]
    }

    /// Returns the mapped frames of the placement before.
    pub fn of_before(&self) -> &[Frame] {
        &self.mapped[..self.n_earlier]
    }

    /// Returns the mapped frames except the last one, which is not in the map yet.
    pub fn all_but_last(&self) -> &[Frame] {
        &self.mapped[..self.mapped.len().saturating_sub(1)]
    }

    /// Returns the same frames, preceded by those of the placement before.
    pub fn after(&self, earlier: Vec<Frame>) -> Self {
        let n_earlier = earlier.len();
        let mapped = earlier.into_iter().chain(self.of_now().iter().cloned()).collect();
        let Self { numbers, set_aside, places, given, .. } = self.clone();
        Self { mapped, n_earlier, numbers, set_aside, places, given }
    }

    /// The frames of this placement, oldest first, in their given poses.
    pub fn as_given(&self) -> Vec<Frame> {
        let mapped = self.numbers.iter().copied().zip(self.of_now());
        let set_aside = self.set_aside.iter().map(|waiting| (waiting.number, &waiting.frame));
        let mut frames: Vec<_> = mapped.chain(set_aside).collect();
        frames.sort_by_key(|(number, _)| *number);
        frames.into_iter().map(|(number, frame)| frame.clone().with_pose(self.given[number])).collect()
    }

    /// Whether one more frame set aside would leave most frames out of the map.
    pub fn would_mostly_be_set_aside(&self) -> bool {
        let n = self.set_aside.len() + 1;
        n >= MANY_SET_ASIDE && 2 * n > self.places.len() + 1
    }

    /// Counts a frame in its given pose and returns its number.
    pub fn add(&mut self, given: Pose) -> usize {
        self.places.push(given);
        self.given.push(given);
        self.places.len() - 1
    }

    /// Adds a frame to the map.
    pub fn map(&mut self, number: usize, frame: Frame) {
        self.places[number] = frame.world_from_camera();
        self.mapped.push(frame);
        self.numbers.push(number);
    }

    /// Moves the last frames in the map to these poses.
    pub fn move_to(&mut self, poses: &[Pose]) {
        let first = self.mapped.len() - poses.len();
        for (i, pose) in (first..).zip(poses) {
            self.mapped[i].move_to(*pose);
            if let Some(of_now) = i.checked_sub(self.n_earlier) {
                self.places[self.numbers[of_now]] = *pose;
            }
        }
    }

    /// Returns the cells shown by the frames of each step in their current poses, added to `seen`.
    pub fn seen_anew(
        &self,
        mut seen: SeenCells,
        bounds: Option<Aabb>,
        table_top: Option<Plane>,
    ) -> SeenCells {
        for number in 0..self.places.len() {
            let mapped = self.numbers.iter().position(|mapped| *mapped == number);
            let frame = mapped.map(|i| &self.of_now()[i..=i]);
            seen.add(frame.unwrap_or_default(), bounds, table_top);
        }
        seen
    }
}
