use super::Situation;
use crate::flow::SetValues;
use crate::gain::ExpectedSurface;
use crate::prior::{SurfacePrior, coarse_enough};
use rayon::prelude::*;

/// What each of the views shows: a set for every view, in the order given, whose items are voxels.
///
/// A voxel's value is the probability that the view shows surface in it that was not seen before. `ray_spacing` is in
/// voxels of the snapshot, or of one that is coarse enough for the prior, positive.
///
/// The memory is 8 bytes for each voxel of each view.
pub(super) fn worth(situation: &Situation<'_>, views: &[usize], ray_spacing: f64) -> SetValues {
    let snapshot = coarse_enough(situation.snapshot);
    let estimate = SurfacePrior::default().estimate(&snapshot);
    let gain = ExpectedSurface::new(&snapshot, situation.intrinsics, &estimate, ray_spacing)
        .expect("the planner checked the ray spacing");
    let rows = views.par_iter().map_init(
        || gain.eye(),
        |eye, &view| {
            let mut row = Vec::new();
            eye.look(&situation.views.pose(view), |item, sighting| {
                row.push((item as u32, estimate.shows(item, sighting)));
            });
            row.sort_unstable_by_key(|(item, _)| *item);
            row
        },
    );
    SetValues::new(estimate.len(), rows.collect())
}
