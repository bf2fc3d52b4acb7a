use crate::Cancelled;
use crate::flow::{SetValues, tidied};
use crate::gain::ExpectedSurface;
use crate::planner::Situation;
use crate::prior::{SurfacePrior, coarse_enough};
use crate::visibility::MeasuredParts;
use rayon::prelude::*;

/// Returns the values of the views: a set for every view, in the order given, whose items are voxels.
///
/// A voxel's value is the probability that the view newly shows surface in it. `ray_spacing` is in voxels of
/// the snapshot, or of a version coarse enough for the prior, positive.
///
/// Memory: 8 bytes for each voxel of each view.
pub(super) fn values_of_views(
    situation: &Situation<'_>,
    views: &[usize],
    ray_spacing: f64,
) -> Result<SetValues, Cancelled> {
    let cancel = situation.cancel();
    let snapshot = coarse_enough(situation.snapshot(), cancel)?;
    let estimate = SurfacePrior::default().estimate(&snapshot, cancel)?;
    let measured = MeasuredParts::new(situation.frames(), &snapshot, cancel)?;
    let gain = ExpectedSurface::new(
        &snapshot,
        situation.intrinsics(),
        situation.depth_range(),
        &measured,
        &estimate,
        ray_spacing,
    )
    .expect("the planner checked the ray spacing");
    let rows = views.par_iter().map_init(
        || gain.evaluator(),
        |evaluator, &view| {
            cancel.check()?;
            let mut row = Vec::new();
            evaluator.shown(&situation.views().pose(view), |item, p| row.push((item as u32, p)));
            row.sort_unstable_by_key(|(item, _)| *item);
            Ok(tidied(row, estimate.len()))
        },
    );
    Ok(SetValues::of_tidied(estimate.len(), rows.collect::<Result<_, Cancelled>>()?))
}
