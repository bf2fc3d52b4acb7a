//! The expected new surface of the view candidates.

use crate::scan::scan_copy::ScanCopy;
use nextview::gain::ExpectedSurface;
use nextview::map::Snapshot;
use nextview::prior::SurfaceEstimate;
use nextview::visibility::MeasuredParts;
use nextview::{Cancel, Error};

/// Number of rays across the box: enough to rank candidates, few enough for thousands of them.
const RAYS_ACROSS: f64 = 8.0;

/// The expected number of new surface voxels by candidate; 0 if it is out of reach.
pub(super) fn candidate_gains(
    scan: &ScanCopy,
    snapshot: &Snapshot,
    estimate: &SurfaceEstimate,
) -> Result<Vec<f64>, Error> {
    let Some(frame) = scan.model_frames.last() else { return Ok(Vec::new()) };
    let spacing = (f64::from(snapshot.block().dims().max_element()) / RAYS_ACROSS).max(1.0);
    let measured = MeasuredParts::new(&scan.model_frames, snapshot, &Cancel::default())?;
    let gain =
        ExpectedSurface::new(snapshot, frame.intrinsics(), scan.depth_range, &measured, estimate, spacing)?;
    let mut evaluator = gain.evaluator();
    let views = &scan.candidates;
    let gain = |view: usize| match views.is_within_reach(view) {
        true => evaluator.gain(&views.pose(view)),
        false => 0.0,
    };
    Ok((0..views.len()).map(gain).collect())
}
