use crate::geometry::Pose;
use crate::placement::{ShownObject, Turn, TurnRefusal, find_turn};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// What an earlier placement has shown of the object, and how that was turned since.
#[derive(Clone, Debug)]
pub(super) struct Earlier {
    pub shown: ShownObject,
    /// As found from the frames so far; none before there are any.
    pub turn: Option<Result<Turn, TurnRefusal>>,
}

/// A turn that is corrected by less than this many voxels at the corners of the object's box stays.
const LEAST_CORRECTION: f64 = 0.1;

impl Earlier {
    /// Its frames as they lie in this pose.
    pub fn frames(&self, now_from_before: &Pose) -> Vec<Frame> {
        let moved = |frame: &Frame| frame.clone().with_pose(*now_from_before * frame.world_from_camera());
        self.shown.frames().iter().map(moved).collect()
    }

    /// The turn by all that is shown now; none if it is known, and as it was.
    pub fn find(&self, now: &ShownObject, cancel: &Cancel) -> Result<Option<Result<Turn, TurnRefusal>>, Cancelled> {
        let Some(Ok(known)) = self.turn else { return find_turn(&self.shown, now, cancel).map(Some) };
        let refined = known.refined(&self.shown, now, cancel)?;
        let lattice = self.shown.snapshot().lattice();
        let corners = lattice.bounds(&self.shown.snapshot().block()).corners();
        let [from, to] = [known, refined].map(|turn| turn.now_from_before);
        let moved = |corner| from.transform_point(corner).distance(to.transform_point(corner));
        let correction = corners.into_iter().map(moved).fold(0.0, f64::max);
        Ok((correction > LEAST_CORRECTION * lattice.voxel_size()).then_some(Ok(refined)))
    }
}
