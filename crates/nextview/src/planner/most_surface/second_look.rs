use crate::Cancelled;
use crate::gain::{BetterSurface, MoreLooks, SurerSurface, is_in_measured_voxels};
use crate::geometry::Pose;
use crate::map::{Occupancy, Snapshot};
use crate::planner::Situation;
use crate::sensor::SurfaceNoise;
use rayon::prelude::*;

/// Value of a voxel that a second look brings to the goal, in voxels of new surface: unseen surface comes
/// first.
const WEIGHT: f64 = 0.1;

/// Value of a voxel at which a view adds a missing look, in voxels of new surface: a tenth, and rays meet
/// every fourth voxel. With 0.1, scans had hardly more looks than without the goal; with 2, they left out new
/// surface and had no more.
const LOOK_WEIGHT: f64 = 0.4;

/// Value of a voxel of surface that a second look makes sure, in voxels of new surface: three, and rays meet
/// every fourth voxel. Behind a surface that scatters over several voxels, the expected new surface is mostly
/// the same surface again. Chosen on recordings: `docs/recorded.md`.
const SURE_WEIGHT: f64 = 12.0;

/// Largest error of sure surface, in voxels.
const TOLERANCE: f64 = 0.25;

/// If less than this share of the occupied voxels is unsure, no view is taken for them.
const FEW: f64 = 0.01;

/// Returns, by view, the value of second looks at known surface, in voxels of new surface. With a goal, these
/// are the gains [`BetterSurface`] and [`MoreLooks`], unless planning is in coarser voxels. Otherwise it is
/// [`SurerSurface`], if the error of the camera is large compared to the voxels. Empty without any.
pub(super) fn values(situation: &Situation<'_>, snapshot: &Snapshot) -> Result<Vec<f64>, Cancelled> {
    let (intrinsics, range) = (situation.intrinsics(), situation.depth_range());
    let better = situation.goal().filter(|(measured, _)| is_in_measured_voxels(snapshot, measured.lattice()));
    let better = better.map(|(measured, goal)| {
        let gain = BetterSurface::new(snapshot, intrinsics, range, measured, goal);
        gain.expect("the session checked the goal")
    });
    let more = situation.looks().filter(|looks| is_in_measured_voxels(snapshot, looks.lattice()));
    let more = more.map(|looks| MoreLooks::new(snapshot, intrinsics, range, looks));
    let surer = unsure_surface(situation, snapshot)?;
    if better.is_none() && more.is_none() && surer.is_none() {
        return Ok(Vec::new());
    }
    let value = |pose: &Pose| {
        let better = better.as_ref().map_or(0.0, |gain| WEIGHT * gain.gain(pose));
        let surer = surer.as_ref().map_or(0.0, |gain| SURE_WEIGHT * gain.gain(pose));
        better + surer + more.as_ref().map_or(0.0, |gain| LOOK_WEIGHT * gain.gain(pose))
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

/// The gain if the error of the camera leaves much of the seen surface unsure; `None` for an exact camera, or
/// if goals state where second looks are wanted.
fn unsure_surface<'a>(
    situation: &Situation<'a>,
    snapshot: &'a Snapshot,
) -> Result<Option<SurerSurface<'a>>, Cancelled> {
    let error = situation.surface_error();
    let has_goal = situation.goal().is_some() || situation.looks().is_some();
    if has_goal || error == SurfaceNoise::default() {
        return Ok(None);
    }
    let (intrinsics, range, frames) = (situation.intrinsics(), situation.depth_range(), situation.frames());
    let tolerance = TOLERANCE * situation.finest_voxel_size();
    let gain = SurerSurface::new(snapshot, intrinsics, range, frames, error, tolerance, situation.cancel())?;
    let few = FEW * snapshot.count(Occupancy::Occupied) as f64;
    Ok(Some(gain).filter(|gain| gain.unsure() > few))
}
