use crate::geometry::Pose;
use crate::placement::{ShownObject, Turn, TurnRefusal, find_turn};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use std::sync::Arc;

/// The object as shown by an earlier placement, and how it was turned since.
#[derive(Clone, Debug)]
pub(super) struct Earlier {
    pub shown: Arc<ShownObject>,
    /// The result from the frames so far; `None` before the first one.
    pub turn: Option<Result<Turn, TurnRefusal>>,
}

/// Smallest correction of a turn that is applied, in voxels at the corners of the object's box.
const LEAST_CORRECTION: f64 = 0.1;

impl Earlier {
    /// Returns its frames moved by this pose.
    pub fn frames(&self, now_from_before: &Pose) -> Vec<Frame> {
        let moved = |frame: &Frame| frame.clone().with_pose(*now_from_before * frame.world_from_camera());
        self.shown.frames().iter().map(moved).collect()
    }

    /// Returns the turn found from everything shown so far; `None` if it is known and unchanged.
    pub fn find(
        &self,
        now: &ShownObject,
        cancel: &Cancel,
    ) -> Result<Option<Result<Turn, TurnRefusal>>, Cancelled> {
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
