use crate::Cancelled;
use crate::gain::{BetterSurface, MoreLooks, is_in_measured_voxels};
use crate::geometry::Pose;
use crate::map::Snapshot;
use crate::planner::Situation;
use rayon::prelude::*;

/// Value of a voxel that a second look brings to the goal, in voxels of new surface: what was not seen comes
/// first.
const WEIGHT: f64 = 0.1;

/// Value of a voxel at which a view adds a look that it lacks, in voxels of new surface: a tenth, and rays
/// meet every fourth voxel. With 0.1, scans had hardly more looks than without the goal; with 2, they left
/// out new surface and had no more.
const LOOK_WEIGHT: f64 = 0.4;

/// By view, the value of second looks at surface that was seen, in voxels of new surface: the gains
/// [`BetterSurface`] and [`MoreLooks`]. Empty without a goal, and while planning is in coarser voxels.
pub(super) fn values(situation: &Situation<'_>, snapshot: &Snapshot) -> Result<Vec<f64>, Cancelled> {
    let (intrinsics, range) = (situation.intrinsics(), situation.depth_range());
    let better = situation.goal().filter(|(measured, _)| is_in_measured_voxels(snapshot, measured.lattice()));
    let better = better.map(|(measured, goal)| {
        let gain = BetterSurface::new(snapshot, intrinsics, range, measured, goal);
        gain.expect("the session checked the goal")
    });
    let more = situation.looks().filter(|looks| is_in_measured_voxels(snapshot, looks.lattice()));
    let more = more.map(|looks| MoreLooks::new(snapshot, intrinsics, range, looks));
    if better.is_none() && more.is_none() {
        return Ok(Vec::new());
    }
    let value = |pose: &Pose| {
        let better = better.as_ref().map_or(0.0, |gain| WEIGHT * gain.gain(pose));
        better + more.as_ref().map_or(0.0, |gain| LOOK_WEIGHT * gain.gain(pose))
    };
    let mut values = vec![0.0; situation.views().len()];
    let open = situation.open_views();
    let gains = open.par_iter().map(|&view| {
        situation.cancel().check()?;
        Ok(value(&situation.views().pose(view)))
    });
    let gains: Vec<f64> = gains.collect::<Result<_, Cancelled>>()?;
    open.into_iter().zip(gains).for_each(|(view, gain)| values[view] = gain);
    Ok(values)
}
