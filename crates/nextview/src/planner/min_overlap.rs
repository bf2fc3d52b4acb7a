use super::{Plan, Situation, ViewPlanner};
use crate::geometry::Pose;
use crate::map::Occupancy;
use crate::visibility::{Crossing, FreeSpace, Ray, RayCaster, RayEnd, Sight};
use crate::{Cancelled, Error};
use rayon::prelude::*;

/// Restricts another planner to views that overlap with known surface, so that their frames can be
/// [aligned](crate::registration) to it.
///
/// The overlap of a view is the share of the object's image filled by known surface. It is the number of rays
/// that end at an occupied voxel from its free side, relative to the mean of that number over the poses of
/// the frames so far, at most 1. Unknown voxels on the way do not matter, as most turn out to be empty. If no
/// view within reach overlaps enough, those that overlap most remain; while nothing is occupied, all do.
///
/// Each of the first two views whose frames wait outside the map, because they could not be aligned, halves
/// the overlap that the next view may lack, so that it links them.
///
/// No overlap is required once the given poses have [proved right](Situation::with_right_poses), or if
/// overlap serves [the alignment alone](Self::to_align) and frames are [not
/// aligned](Situation::with_aligned_frames).
///
/// The other planner's [`Outlook`](super::Outlook) then counts only the remaining views.
///
/// ```
/// use nextview::planner::{MinOverlap, RandomViews};
///
/// assert!(MinOverlap::new(0.4, Box::new(RandomViews { seed: 1 })).is_ok());
/// assert!(MinOverlap::new(40.0, Box::new(RandomViews { seed: 1 })).is_err());
/// ```
pub struct MinOverlap {
    share: f64,
    serves_alignment_alone: bool,
    planner: Box<dyn ViewPlanner>,
}

/// Distance between neighbouring rays at the far side of the box, in voxels of the finest size: a few hundred
/// rays per view.
const RAY_SPACING: f64 = 4.0;

/// Maximum number of halvings by frames that wait outside the map: views that show nothing new help no more.
const MAX_HALVINGS: usize = 2;

/// Number of voxels before an occupied one that must not be unknown: rays through the gaps of a surface
/// measured from its other side pass only one or two.
const FREE_BEFORE: usize = 3;

impl MinOverlap {
    /// Restricts a planner to views of at least this overlap, 0..=1.
    pub fn new(share: f64, planner: Box<dyn ViewPlanner>) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&share) {
            return Ok(Self { share, serves_alignment_alone: false, planner });
        }
        Err(Error::invalid("min_overlap", share, "a number in 0..=1"))
    }

    /// Restricts a planner to views of at least this overlap, 0..=1, while frames are aligned.
    pub fn to_align(share: f64, planner: Box<dyn ViewPlanner>) -> Result<Self, Error> {
        Ok(Self { serves_alignment_alone: true, ..Self::new(share, planner)? })
    }
}

impl ViewPlanner for MinOverlap {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let is_idle = self.serves_alignment_alone && !situation.are_frames_aligned();
        if situation.are_poses_right() || is_idle {
            return self.planner.plan(situation);
        }
        let n_waiting = situation.visited().len().saturating_sub(situation.frames().len());
        let share = 1.0 - (1.0 - self.share) * 0.5_f64.powi(n_waiting.min(MAX_HALVINGS) as i32);
        let open = situation.open_views();
        let overlaps = overlaps(situation, &open)?;
        let most = overlaps.iter().copied().fold(0.0, f64::max);
        let mut is_left = vec![false; situation.views().len()];
        for (view, overlap) in open.into_iter().zip(overlaps) {
            is_left[view] = overlap >= share.min(most);
        }
        let views = situation.views().clone().only(|view| is_left[view]);
        self.planner.plan(&situation.with_views(&views))
    }

    fn seeks_surface(&self) -> bool {
        self.planner.seeks_surface()
    }
}

/// The overlap of each of the views, 0..=1; 0 for views that show nothing, and before the first frame.
fn overlaps(situation: &Situation<'_>, views: &[usize]) -> Result<Vec<f64>, Cancelled> {
    let (snapshot, cancel) = (situation.snapshot(), situation.cancel());
    let spacing = situation.in_snapshot_voxels(RAY_SPACING);
    let caster = RayCaster::new(snapshot, situation.intrinsics(), spacing, Sight::endless(FreeSpace::Clear))
        .expect("the spacing is positive")
        .within(situation.depth_range());
    let n_known = |pose: &Pose| {
        let mut n = 0.0;
        caster.try_cast(pose, |ray| {
            n += shows_known_surface(&ray, snapshot.occupancy()) as u8 as f64;
            cancel.check()
        })?;
        Ok(n)
    };
    let frames = situation.frames();
    let in_frames = frames.par_iter().map(|frame| n_known(&frame.world_from_camera()));
    let full = in_frames.collect::<Result<Vec<f64>, _>>()?.iter().sum::<f64>() / frames.len().max(1) as f64;
    if full == 0.0 {
        return Ok(vec![0.0; views.len()]);
    }
    let overlap = |&view: &usize| Ok((n_known(&situation.views().pose(view))? / full).min(1.0));
    views.par_iter().map(overlap).collect()
}

/// Whether a ray meets an occupied voxel from the free side from which it was measured.
fn shows_known_surface(ray: &Ray<'_>, occupancy: &[Occupancy]) -> bool {
    let is_free = |crossing: &Crossing| occupancy[crossing.voxel as usize] != Occupancy::Unknown;
    matches!(ray.end, RayEnd::Occupied(_)) && ray.crossings.iter().rev().take(FREE_BEFORE).all(is_free)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cancel;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::{LogOdds, Snapshot};
    use crate::planner::RandomViews;
    use crate::sensor::{DepthImage, Frame, Intrinsics};
    use crate::view::{ViewSpace, generate, look_at};
    use glam::{DVec3, IVec3, UVec3};

    /// A plate across the box at x = 0, in front of which (+x) all is free and behind which all is unknown.
    fn plate() -> Snapshot {
        let block = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap();
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| match key.x {
            0 => Some(LogOdds(0.85)),
            1.. => Some(LogOdds(-0.4)),
            _ => None,
        })
    }

    fn unknown() -> Snapshot {
        let block = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap();
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None)
    }

    struct Setup {
        snapshot: Snapshot,
        frames: Vec<Frame>,
        views: ViewSpace,
        intrinsics: Intrinsics,
        cancel: Cancel,
    }

    impl Setup {
        fn new(snapshot: Snapshot) -> Self {
            let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 60).unwrap();
            let intrinsics = Intrinsics::d435i();
            // Only their places matter.
            let image = DepthImage::from_metres(640, 480, vec![f32::NAN; intrinsics.n_pixels()]).unwrap();
            let from = look_at(DVec3::X * 0.4, DVec3::ZERO).unwrap();
            let frame = Frame::new(image, intrinsics, from, 1.0).unwrap();
            Self {
                snapshot,
                frames: vec![frame.clone(), frame],
                views,
                intrinsics,
                cancel: Cancel::default(),
            }
        }

        fn situation<'a>(&'a self, visited: &'a [usize]) -> Situation<'a> {
            let Self { snapshot, views, intrinsics, .. } = self;
            let situation = Situation::new(snapshot, views, intrinsics, &self.cancel);
            situation.with_frames(&self.frames).with_visited(visited).unwrap()
        }
    }

    /// The views chosen by random planners with many seeds.
    fn choices(share: f64, situation: &Situation<'_>) -> Vec<usize> {
        let planner = |seed| MinOverlap::new(share, Box::new(RandomViews { seed })).unwrap();
        let choice = |seed| planner(seed).plan(situation).unwrap().choice;
        let mut views: Vec<usize> = (0..1000).filter_map(|seed| Some(choice(seed)?.view)).collect();
        views.sort_unstable();
        views.dedup();
        views
    }

    /// The open views with enough overlap.
    fn expected(situation: &Situation<'_>, is_enough: impl Fn(f64) -> bool) -> Vec<usize> {
        let open = situation.open_views();
        let overlaps = overlaps(situation, &open).unwrap();
        open.into_iter()
            .zip(overlaps)
            .filter(|(_, overlap)| is_enough(*overlap))
            .map(|(view, _)| view)
            .collect()
    }

    #[test]
    fn what_is_seen_from_the_known_side_overlaps() {
        let setup = Setup::new(plate());
        let all: Vec<usize> = (0..60).collect();
        for (view, overlap) in overlaps(&setup.situation(&[]), &all).unwrap().into_iter().enumerate() {
            let position = setup.views.pose(view).translation();
            let is_fine = match position.x {
                x if x > 0.38 => overlap > 0.9,
                x if x < -0.1 => overlap < 0.2, // of what is known, the plate's edge is seen
                _ => (0.0..=1.0).contains(&overlap),
            };
            assert!(is_fine, "{overlap} from {position}");
        }
    }

    #[test]
    fn only_views_that_overlap_are_left() {
        let setup = Setup::new(plate());
        let situation = setup.situation(&[0, 7]);
        for share in [0.0, 0.3, 0.8, 1.0] {
            assert_eq!(choices(share, &situation), expected(&situation, |overlap| overlap >= share));
        }
    }

    #[test]
    fn where_poses_are_right_all_views_are_left() {
        let setup = Setup::new(plate());
        let situation = setup.situation(&[0, 7]).with_right_poses(true);
        assert_eq!(choices(1.0, &situation), situation.open_views());
    }

    #[test]
    fn frames_that_wait_outside_the_map_call_for_more_overlap() {
        let mut setup = Setup::new(plate());
        for (visited, needed) in
            [(&[0, 7, 9][..], 0.65), (&[0, 7, 9, 11], 0.825), (&[0, 7, 9, 11, 13], 0.825)]
        {
            let situation = setup.situation(visited);
            assert_eq!(choices(0.3, &situation), expected(&situation, |overlap| overlap >= needed));
        }
        setup.frames.clear();
        let situation = setup.situation(&[]);
        assert_eq!(choices(0.3, &situation).len(), 60, "nothing is known yet");
    }

    #[test]
    fn where_none_overlaps_enough_those_that_overlap_most_are_left() {
        let mut setup = Setup::new(plate());
        setup.views = setup.views.restricted(|position| position.x < 0.1);
        let situation = setup.situation(&[]);
        let most = overlaps(&situation, &situation.open_views()).unwrap().into_iter().fold(0.0, f64::max);
        assert!((0.1..1.0).contains(&most), "{most}");
        assert_eq!(choices(1.0, &situation), expected(&situation, |overlap| overlap == most));
    }

    #[test]
    fn while_nothing_is_occupied_all_views_are_left() {
        let setup = Setup::new(unknown());
        assert_eq!(choices(1.0, &setup.situation(&[])), (0..60).collect::<Vec<_>>());
    }
}
