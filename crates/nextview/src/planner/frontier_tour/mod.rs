mod clusters;

use super::utility::check_ray_spacing;
use super::{Choice, Plan, Situation, ViewPlanner};
use crate::flow::{Incidence, fewest_sets};
use crate::map::frontier;
use crate::motion::{KeepOut, tour_length, tour_unless};
use crate::visibility::{FreeSpace, RayCaster};
use crate::{Cancelled, Error};
use clusters::without_small_clusters;
use glam::DVec3;
use rayon::prelude::*;

/// Takes the first view of the shortest tour through few views that together see the whole frontier: the two
/// stages of Meng et al. (RA-L 2017).
///
/// Stage one chooses the [fewest](fewest_sets) open views whose rays cross every frontier voxel that any of
/// them crosses. Stage two orders these by the shortest open [tour](crate::motion::tour) from where the
/// camera is, around the ball through the corners of the box. The tour is planned again after every frame;
/// there is no choice once no open view sees a frontier voxel. Clusters of fewer than four frontier voxels
/// count only if there are no others.
///
/// The publication samples its views around the frontier; here they are the view candidates.
#[derive(Clone, Copy, Debug)]
pub struct FrontierTour {
    ray_spacing: f64,
}

impl FrontierTour {
    /// Creates a planner with this ray spacing at the far side of the box, in voxels of the finest size, at
    /// least 0.1.
    pub fn new(ray_spacing: f64) -> Result<Self, Error> {
        check_ray_spacing(ray_spacing)?;
        Ok(Self { ray_spacing })
    }

    /// The frontier voxels that each of the views sees, as places in `frontier`.
    fn seen(
        &self,
        situation: &Situation<'_>,
        views: &[usize],
        frontier: &[usize],
    ) -> Result<Vec<Vec<u32>>, Cancelled> {
        let (snapshot, cancel) = (situation.snapshot(), situation.cancel());
        let mut places = vec![None; snapshot.block().n_voxels()];
        frontier.iter().zip(0..).for_each(|(&voxel, place)| places[voxel] = Some(place));
        let spacing = situation.in_snapshot_voxels(self.ray_spacing);
        let caster = RayCaster::new(snapshot, situation.intrinsics(), spacing, FreeSpace::Clear)
            .expect("the constructor checked the ray spacing")
            .within(situation.depth_range());
        let of_view = |&view: &usize| {
            let mut seen: Vec<u32> = Vec::new();
            caster.try_cast(&situation.views().pose(view), |ray| {
                seen.extend(ray.crossings.iter().filter_map(|crossing| places[crossing.voxel as usize]));
                cancel.check()
            })?;
            seen.sort_unstable();
            seen.dedup();
            Ok(seen)
        };
        views.par_iter().map(of_view).collect()
    }
}

impl ViewPlanner for FrontierTour {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let (snapshot, cancel) = (situation.snapshot(), situation.cancel());
        let open = situation.open_views();
        let frontier = without_small_clusters(&frontier(snapshot), &snapshot.block());
        let seen = self.seen(situation, &open, &frontier)?;
        let mut viewers = Incidence::new(frontier.len(), open.len());
        for (set, seen) in (0..).zip(&seen) {
            seen.iter().for_each(|&place| viewers.insert(place as usize, set));
        }
        let cover = fewest_sets(&viewers, cancel)?;
        let position = |set: u32| situation.views().pose(open[set as usize]).translation();
        let positions: Vec<DVec3> = cover.iter().map(|&set| position(set)).collect();
        let ball = KeepOut::around(&snapshot.lattice().bounds(&snapshot.block()), 0.0)
            .expect("a block of voxels is a finite box");
        let start = situation.camera_position();
        let order = tour_unless(start, &positions, &ball, cancel)?;
        let choice = order.first().map(|&first| {
            let n_seen = seen[cover[first] as usize].len() as f64;
            let length = tour_length(start, order.iter().map(|&place| positions[place]), &ball);
            Choice {
                view: open[cover[first] as usize],
                score: n_seen / frontier.len() as f64,
                runner_up: order.get(1).map(|&second| open[cover[second] as usize]),
                explanation: Some(
                    [
                        ("frontier_voxels", frontier.len() as f64),
                        ("seen_frontier_voxels", n_seen),
                        ("tour_length_m", length),
                        ("tour_views", order.len() as f64),
                    ]
                    .into(),
                ),
            }
        });
        Ok(Plan { choice, ..Plan::default() })
    }
}
