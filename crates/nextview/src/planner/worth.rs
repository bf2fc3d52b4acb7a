use super::Situation;
use crate::flow::SetValues;
use crate::gain::LocalGain;
use crate::geometry::Pose;
use crate::visibility::{FreeSpace, Paths, RayCaster, WorthCaster};
use rayon::prelude::*;

/// What each of the views shows: a set for every view, in the order given, whose items are voxels.
///
/// A voxel counts once for a view, as the ray shows it that sees it best: its value is the local gain of that one crossing,
/// H(x) P(vis_x) P(obj_x). `ray_spacing` is in voxels of the finest size, positive.
///
/// The memory is 8 bytes for each voxel of each view.
pub(super) fn worth(situation: &Situation<'_>, views: &[usize], ray_spacing: f64) -> SetValues {
    let spacing = situation.in_snapshot_voxels(ray_spacing);
    let caster = RayCaster::new(situation.snapshot, situation.intrinsics, spacing, FreeSpace::default())
        .expect("the planner checked the ray spacing");
    let gain = LocalGain::new(situation.snapshot);
    let caster = WorthCaster::new(caster, situation.snapshot, gain.weights());
    let look = |eye: &mut Eye<'_>, &view: &usize| eye.look(&situation.views.pose(view));
    let rows = views.par_iter().map_init(|| Eye::new(&caster), look).collect();
    SetValues::new(caster.n_items(), rows)
}

/// Looks from one view after the other.
struct Eye<'a> {
    caster: &'a WorthCaster<'a>,
    paths: Paths,
    /// By item, the best quality in the view; zeros between views.
    best: Vec<f32>,
    /// The items seen in the view.
    seen: Vec<u32>,
}

impl<'a> Eye<'a> {
    fn new(caster: &'a WorthCaster<'a>) -> Self {
        Self { caster, paths: caster.paths(), best: vec![0.0; caster.n_items()], seen: Vec::new() }
    }

    fn look(&mut self, world_from_camera: &Pose) -> Vec<(u32, f32)> {
        let Self { caster, paths, best, seen } = self;
        caster.cast(world_from_camera, paths, |item, quality| {
            let (best, quality) = (&mut best[item], quality as f32);
            if quality > *best {
                if *best == 0.0 {
                    seen.push(item as u32);
                }
                *best = quality;
            }
        });
        seen.sort_unstable();
        seen.drain(..).map(|item| (item, std::mem::take(&mut best[item as usize]))).collect()
    }
}
