//! What the view candidates are expected to show.

use nextview::gain::ExpectedSurface;
use nextview::map::Snapshot;
use nextview::prior::SurfaceEstimate;
use nextview::session::Session;
use nextview::{Cancel, Error};

/// Rays side by side across the box: enough to rank candidates, few enough for thousands of them.
const RAYS_ACROSS: f64 = 8.0;

/// By candidate, the voxels of surface that it is expected to show anew; 0 where it is not within reach.
pub(super) fn candidate_gains(
    session: &Session,
    snapshot: &Snapshot,
    estimate: &SurfaceEstimate,
    cancel: &Cancel,
) -> Result<Vec<f64>, Error> {
    let Some(frame) = session.frames().last() else { return Ok(Vec::new()) };
    let spacing = (f64::from(snapshot.block().dims().max_element()) / RAYS_ACROSS).max(1.0);
    let gain = ExpectedSurface::new(snapshot, frame.intrinsics(), session.depth_range(), estimate, spacing)?;
    let mut evaluator = gain.evaluator();
    let views = session.views();
    let gain = |view: usize| match views.is_within_reach(view) {
        true => cancel.check().map(|()| evaluator.gain(&views.pose(view))),
        false => Ok(0.0),
    };
    Ok((0..views.len()).map(gain).collect::<Result<_, _>>()?)
}
