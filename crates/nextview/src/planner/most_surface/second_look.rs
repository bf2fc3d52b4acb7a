use crate::Cancelled;
use crate::gain::{BetterSurface, is_in_measured_voxels};
use crate::map::Snapshot;
use crate::planner::Situation;
use rayon::prelude::*;

/// Value of a voxel that a second look brings to the goal, in voxels of new surface: what was not seen comes
/// first.
const WEIGHT: f64 = 0.1;

/// By view, the value of second looks at surface that was seen, in voxels of new surface: the gain
/// [`BetterSurface`]. Empty without a goal, and while planning is in coarser voxels.
pub(super) fn values(situation: &Situation<'_>, snapshot: &Snapshot) -> Result<Vec<f64>, Cancelled> {
    let Some((measured, goal)) = situation.goal() else { return Ok(Vec::new()) };
    if !is_in_measured_voxels(snapshot, measured) {
        return Ok(Vec::new());
    }
    let (intrinsics, range) = (situation.intrinsics(), situation.depth_range());
    let gain = BetterSurface::new(snapshot, intrinsics, range, measured, goal);
    let gain = gain.expect("the session checked the goal");
    let mut values = vec![0.0; situation.views().len()];
    let open = situation.open_views();
    let gains = open.par_iter().map(|&view| {
        situation.cancel().check()?;
        Ok(WEIGHT * gain.gain(&situation.views().pose(view)))
    });
    let gains: Vec<f64> = gains.collect::<Result<_, Cancelled>>()?;
    open.into_iter().zip(gains).for_each(|(view, gain)| values[view] = gain);
    Ok(values)
}
