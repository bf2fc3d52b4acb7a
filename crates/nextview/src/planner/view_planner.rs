use super::Explanation;
use crate::geometry::{Plane, Pose};
use crate::map::Snapshot;
use crate::motion::{MotionConfig, Surroundings, Trajectory};
use crate::sensor::{DepthRange, Frame, Intrinsics, SurfaceNoise};
use crate::surface::{MeasuredCells, SurfaceLooks};
use crate::view::ViewSpace;
use crate::{Cancel, Error};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Chooses the next view.
///
/// A planner serves one scan, since it may remember its earlier plans. Otherwise, equal situations give equal
/// plans. A plan that is cancelled or fails leaves the planner unchanged.
///
/// ```
/// use nextview::Error;
/// use nextview::planner::{Choice, Plan, Situation, ViewPlanner};
///
/// /// Takes the highest view within reach.
/// struct FromAbove;
///
/// impl ViewPlanner for FromAbove {
///     fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
///         let height = |view: usize| situation.views().pose(view).translation().z;
///         let highest = situation.open_views().into_iter().max_by(|&a, &b| height(a).total_cmp(&height(b)));
///         Ok(Plan { choice: highest.map(|view| Choice::new(view, height(view))), ..Plan::default() })
///     }
/// }
/// # use glam::{DVec3, IVec3, UVec3};
/// # use nextview::{Cancel, map::Snapshot, sensor::Intrinsics};
/// # use nextview::geometry::{Lattice, VoxelBlock};
/// # use nextview::view::generate;
/// # let block = VoxelBlock::new(IVec3::ZERO, UVec3::splat(2)).unwrap();
/// # let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
/// # let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 10).unwrap();
/// # let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
/// # let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_visited(&[0]).unwrap();
/// assert_eq!(FromAbove.plan(&situation).unwrap().choice.unwrap().view, 1);
/// ```
pub trait ViewPlanner: Send {
    /// Ranks the open views and picks one; no choice if no view gains anything.
    ///
    /// Long computations check [`Situation::cancel`] and fail if it is set. A planner that depends on
    /// something else that can fail, such as another program, reports that as [`Error::Planner`].
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error>;

    /// Whether views are chosen for the surface that they show. A scan then ends when the surface no longer
    /// [grows](crate::session::StopConfig::progress). Default: yes.
    fn seeks_surface(&self) -> bool {
        true
    }
}

/// All information available to a planner.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    snapshot: &'a Snapshot,
    frames: &'a [Frame],
    views: &'a ViewSpace,
    intrinsics: &'a Intrinsics,
    depth_range: DepthRange,
    surface_error: SurfaceNoise,
    are_poses_right: bool,
    are_frames_aligned: bool,
    measured: Option<(&'a MeasuredCells, f64)>,
    looks: Option<&'a SurfaceLooks>,
    /// Numbers of candidates.
    visited: &'a [usize],
    /// By candidate, seconds; `None` where the camera cannot go now.
    approaches: Option<&'a [Option<f64>]>,
    motion: MotionConfig,
    surroundings: Surroundings,
    table: Option<Plane>,
    /// Maximum for the whole scan.
    max_views: usize,
    /// At most the voxel size of the snapshot, metres, and at least the size that [`MOST_VOXELS`] allows.
    finest_voxel_size: f64,
    cancel: &'a Cancel,
}

/// Maximum number of the finest voxels along the longest side of the box, as in an OctoMap. The spacing of
/// planning rays is in these voxels, so the limit keeps their number finite.
const MOST_VOXELS: f64 = 65_536.0;

impl<'a> Situation<'a> {
    /// Returns the situation before the first view, for a map of the box around the object, the view
    /// candidates, the optics of the camera, and a flag that cancels planning. The scan ends at the voxel
    /// size of the snapshot.
    pub fn new(
        snapshot: &'a Snapshot,
        views: &'a ViewSpace,
        intrinsics: &'a Intrinsics,
        cancel: &'a Cancel,
    ) -> Self {
        let finest_voxel_size = snapshot.lattice().voxel_size();
        Self {
            snapshot,
            frames: &[],
            views,
            intrinsics,
            depth_range: DepthRange::default(),
            surface_error: SurfaceNoise::default(),
            are_poses_right: false,
            are_frames_aligned: false,
            measured: None,
            looks: None,
            visited: &[],
            approaches: None,
            motion: MotionConfig::default(),
            surroundings: Surroundings::default(),
            table: None,
            max_views: usize::MAX,
            finest_voxel_size,
            cancel,
        }
    }

    /// Sets the depths that the camera measures. Default: all.
    pub fn with_depth_range(self, depth_range: DepthRange) -> Self {
        Self { depth_range, ..self }
    }

    /// Sets the random error of the camera, for which surface is worth second looks. Default: none.
    pub fn with_surface_error(self, surface_error: SurfaceNoise) -> Self {
        Self { surface_error, ..self }
    }

    /// Sets whether the given poses have proved right; later frames then need no overlap to be placed.
    /// Default: no.
    pub fn with_right_poses(self, are_poses_right: bool) -> Self {
        Self { are_poses_right, ..self }
    }

    /// Sets whether frames are [aligned](crate::registration) to the known surface, which they must then
    /// overlap. Default: no.
    pub fn with_aligned_frames(self, are_frames_aligned: bool) -> Self {
        Self { are_frames_aligned, ..self }
    }

    /// Sets an accuracy goal for measured surface: how well it was measured, and the required standard
    /// deviation in metres, positive. Default: no goal and no second looks.
    pub fn with_goal(self, measured: &'a MeasuredCells, goal: f64) -> Self {
        Self { measured: Some((measured, goal)), ..self }
    }

    /// Sets a goal for the number of looks at surface, with the looks so far. Default: no second looks.
    pub fn with_looks(self, looks: &'a SurfaceLooks) -> Self {
        Self { looks: Some(looks), ..self }
    }

    /// Sets the frames that the snapshot was made from, oldest first.
    pub fn with_frames(self, frames: &'a [Frame]) -> Self {
        Self { frames, ..self }
    }

    /// Sets the views taken so far, in order. Fails if one is not a candidate.
    pub fn with_visited(self, visited: &'a [usize]) -> Result<Self, Error> {
        match visited.iter().find(|view| **view >= self.views.len()) {
            Some(view) => Err(Error::invalid("visited", view, "numbers below that of view candidates")),
            None => Ok(Self { visited, ..self }),
        }
    }

    /// Sets the robot's travel time to each candidate in seconds; `None` if it cannot be reached now. Fails
    /// if the number of times differs from the number of candidates.
    pub fn with_approaches(self, approaches: &'a [Option<f64>]) -> Result<Self, Error> {
        if approaches.len() == self.views.len() {
            return Ok(Self { approaches: Some(approaches), ..self });
        }
        Err(Error::invalid("number of approaches", approaches.len(), "that of view candidates"))
    }

    /// Sets the motion of the camera and its surroundings. Default: the default motion in an empty room.
    /// Fails on a configuration out of range.
    pub fn with_motion(self, motion: MotionConfig, surroundings: Surroundings) -> Result<Self, Error> {
        motion.check()?;
        Ok(Self { motion, surroundings, ..self })
    }

    /// Sets the table that the object stands on, its normal upwards. Default: none.
    pub fn with_table(self, table: Option<Plane>) -> Self {
        Self { table, ..self }
    }

    /// Sets the maximum number of views of the scan. Default: unlimited.
    pub fn with_max_views(self, max_views: usize) -> Self {
        Self { max_views, ..self }
    }

    /// Sets the voxel size at the end of the scan, metres: that of the snapshot, or finer.
    ///
    /// Fails if the voxels are coarser, or if more than 65,536 of them fit along the box.
    pub fn with_finest_voxel_size(self, voxel_size: f64) -> Result<Self, Error> {
        let size = self.snapshot.lattice().voxel_size();
        let n_along = self.snapshot.block().dims().max_element() as f64 * (size / voxel_size);
        // Rounding may make the same size a little larger.
        if voxel_size > 0.0 && voxel_size <= size * (1.0 + 1e-9) && n_along <= MOST_VOXELS {
            return Ok(Self { finest_voxel_size: voxel_size, ..self });
        }
        let expected = "at most the snapshot's, and at most 65,536 voxels along the box";
        Err(Error::invalid("finest_voxel_size", voxel_size, expected))
    }

    /// Replaces the candidates by the same number of others.
    pub(super) fn with_views(self, views: &'a ViewSpace) -> Self {
        Self { views, ..self }
    }

    /// The map of the box around the object.
    pub fn snapshot(&self) -> &'a Snapshot {
        self.snapshot
    }

    /// The frames that the snapshot was made from, oldest first; empty if only a map of them remains.
    pub fn frames(&self) -> &'a [Frame] {
        self.frames
    }

    /// The view candidates.
    pub fn views(&self) -> &'a ViewSpace {
        self.views
    }

    /// The optics of the camera.
    pub fn intrinsics(&self) -> &'a Intrinsics {
        self.intrinsics
    }

    /// The depths that the camera measures.
    pub fn depth_range(&self) -> DepthRange {
        self.depth_range
    }

    /// The random error of the camera, for which surface is worth second looks.
    pub fn surface_error(&self) -> SurfaceNoise {
        self.surface_error
    }

    /// The table that the object stands on, if one is known.
    pub fn table(&self) -> Option<Plane> {
        self.table
    }

    /// Whether the given poses have proved right.
    pub fn are_poses_right(&self) -> bool {
        self.are_poses_right
    }

    /// Whether frames are aligned to the known surface.
    pub fn are_frames_aligned(&self) -> bool {
        self.are_frames_aligned
    }

    /// How well surface was measured, and the required accuracy, metres; `None` if there is no goal.
    pub fn goal(&self) -> Option<(&'a MeasuredCells, f64)> {
        self.measured
    }

    /// The looks at surface so far, and their goal; `None` if there is no such goal.
    pub fn looks(&self) -> Option<&'a SurfaceLooks> {
        self.looks
    }

    /// The views taken so far, in order; all are candidates.
    pub fn visited(&self) -> &'a [usize] {
        self.visited
    }

    /// Number of views that may still be taken.
    pub fn n_views_left(&self) -> usize {
        self.max_views.saturating_sub(self.visited.len())
    }

    /// Voxel size at the end of the scan, metres: that of the snapshot, or finer. The spacing of rays is in
    /// voxels of this size, so plans in coarser voxels have as many rays: ten coarse voxels may be wider than
    /// the box.
    pub fn finest_voxel_size(&self) -> f64 {
        self.finest_voxel_size
    }

    /// A flag that cancels planning.
    pub fn cancel(&self) -> &'a Cancel {
        self.cancel
    }

    /// Whether the camera can go to this view now: it is within reach, and no robot has excluded it.
    pub fn can_go(&self, view: usize) -> bool {
        let is_stated = self.approaches.is_none_or(|approaches| approaches[view].is_some());
        is_stated && self.views.is_within_reach(view)
    }

    /// The views within reach, where the camera can go now, and not yet visited, in increasing order.
    pub fn open_views(&self) -> Vec<usize> {
        let mut is_open: Vec<bool> = (0..self.views.len()).map(|view| self.can_go(view)).collect();
        self.visited.iter().for_each(|&view| is_open[view] = false);
        (0..is_open.len()).filter(|&view| is_open[view]).collect()
    }

    /// The position of the camera, metres: that of the last frame, or else of the last view; `None` before
    /// the first.
    pub fn camera_position(&self) -> Option<DVec3> {
        self.world_from_camera().map(|pose| pose.translation())
    }

    fn world_from_camera(&self) -> Option<Pose> {
        let last_frame = self.frames.last().map(|frame| frame.world_from_camera());
        last_frame.or_else(|| self.visited.last().map(|&view| self.views.pose(view)))
    }

    /// Cost of going to a view: seconds if a robot [stated](Self::with_approaches) them, else the straight
    /// distance from [where the camera is](Self::camera_position), metres. `None` before the first view.
    pub fn travel(&self, view: usize) -> Option<f64> {
        let stated = self.approaches.and_then(|approaches| approaches[view]);
        let distance = |from: DVec3| self.views.pose(view).translation().distance(from);
        self.camera_position().map(|from| stated.unwrap_or_else(|| distance(from)))
    }

    /// Time to go to a view and to measure there, seconds: the travel time that a robot
    /// [stated](Self::with_approaches), or else that of the [trajectory](Self::with_motion), plus the sensing
    /// time. Infinite if the view cannot be reached.
    pub fn seconds(&self, view: usize) -> f64 {
        let stated = self.approaches.map(|approaches| approaches[view].unwrap_or(f64::INFINITY));
        let way = |from: Pose| {
            let trajectory = Trajectory::new(&from, &self.views.pose(view), &self.surroundings, &self.motion);
            trajectory.map_or(f64::INFINITY, |trajectory| trajectory.duration())
        };
        let way = stated.unwrap_or_else(|| self.world_from_camera().map_or(0.0, way));
        way + self.motion.sensing_time
    }

    /// Converts a distance in voxels of the finest size to voxels of the snapshot.
    pub(super) fn in_snapshot_voxels(&self, distance: f64) -> f64 {
        distance * (self.finest_voxel_size / self.snapshot.lattice().voxel_size())
    }
}

/// A planner's answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The next best view and why; `None` if no view gains anything.
    pub choice: Option<Choice>,
    /// The views to visit after the choice without another plan, from planners that choose several views at
    /// once.
    pub itinerary: Option<Itinerary>,
    /// The planner's expectations; `None` from planners without expectations.
    pub outlook: Option<Outlook>,
}

/// The expectations of a planner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outlook {
    /// Number of voxels occupied so far, in the voxel size of the planner.
    pub n_seen: usize,
    /// Total number of voxels expected to be added after each of the next views, the chosen view first; empty
    /// if none was chosen.
    pub n_expected: Vec<f64>,
    /// Number of further voxels expected to be seen if every view were taken.
    pub n_unseen: f64,
}

impl Outlook {
    /// The estimated share, 0..=1, of the visible surface that has been seen; 1 if none is visible.
    pub fn completeness(&self) -> f64 {
        let n_seen = self.n_seen as f64;
        if n_seen + self.n_unseen > 0.0 { n_seen / (n_seen + self.n_unseen) } else { 1.0 }
    }

    /// The estimated completeness after each of the next views, the chosen view first.
    pub fn forecast(&self) -> Vec<f64> {
        let all = self.n_seen as f64 + self.n_unseen;
        let after = |n: &f64| if all > 0.0 { (self.n_seen as f64 + n.min(self.n_unseen)) / all } else { 1.0 };
        self.n_expected.iter().map(after).collect()
    }

    /// Number of voxels that the chosen view is expected to add; 0 if none was chosen.
    pub fn n_expected_next(&self) -> f64 {
        self.n_expected.first().copied().unwrap_or(0.0)
    }

    /// The largest expected gain of one of the next views, as a share of the surface seen. Later views count
    /// too, since the chosen one may have been chosen only because it is near. Infinite if nothing was seen.
    pub fn gain(&self) -> f64 {
        let later = self.n_expected.windows(2).map(|two| two[1] - two[0]);
        let largest = later.fold(self.n_expected_next(), f64::max);
        if self.n_seen > 0 { largest / self.n_seen as f64 } else { f64::INFINITY }
    }
}

/// Views that were chosen together, in the order of the tour.
///
/// Valid while the camera sees what was expected. After that, the map that they were chosen for is outdated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Itinerary {
    /// The views; the first is the choice of the plan.
    pub legs: Vec<Leg>,
    /// Maximum deviation from the expected number of voxels, as a share of that number, at least 0.
    pub tolerance: f64,
}

/// A view of an itinerary.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// The view and why it was chosen.
    pub choice: Choice,
    /// Expected number of newly occupied voxels after the views before it, positive. A factor that is about
    /// the same for all legs and plans does not matter.
    pub expected: f64,
}

/// A view and why it was chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Number of the view.
    pub view: usize,
    /// The quantity that the planner maximised, in the planner's unit.
    pub score: f64,
    /// The second best view, if there is one.
    #[serde(default)]
    pub runner_up: Option<usize>,
    /// The quantities behind the score, from planners that explain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
}

impl Choice {
    /// Creates a choice without runner-up and explanation.
    pub fn new(view: usize, score: f64) -> Self {
        Self { view, score, runner_up: None, explanation: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outlook(n_seen: usize, n_expected: f64, n_unseen: f64) -> Outlook {
        Outlook { n_seen, n_expected: vec![n_expected], n_unseen }
    }

    #[test]
    fn completeness_is_the_share_seen() {
        assert_eq!(outlook(90, 0.0, 10.0).completeness(), 0.9);
        assert_eq!(outlook(90, 0.0, 0.0).completeness(), 1.0);
        assert_eq!(outlook(0, 0.0, 10.0).completeness(), 0.0);
        assert_eq!(outlook(0, 0.0, 0.0).completeness(), 1.0, "nothing can be seen");
    }

    #[test]
    fn a_forecast_is_the_completeness_that_the_next_views_lead_to() {
        let outlook = Outlook { n_seen: 80, n_expected: vec![8.0, 14.0, 25.0], n_unseen: 20.0 };
        assert_eq!(outlook.forecast(), [0.88, 0.94, 1.0]);
        assert!(Outlook { n_expected: Vec::new(), ..outlook }.forecast().is_empty());
        assert_eq!(self::outlook(0, 0.0, 0.0).forecast(), [1.0], "nothing can be seen");
    }

    #[test]
    fn gain_is_a_share_of_what_was_seen() {
        assert_eq!(outlook(80, 20.0, 10.0).gain(), 0.25);
        assert_eq!(outlook(80, 0.0, 10.0).gain(), 0.0);
        assert_eq!(outlook(0, 20.0, 30.0).gain(), f64::INFINITY);
        assert_eq!(outlook(0, 0.0, 0.0).gain(), f64::INFINITY, "a number, even of nothing");
        let near_first = Outlook { n_expected: vec![1.0, 17.0, 20.0], ..outlook(80, 0.0, 30.0) };
        assert_eq!(near_first.gain(), 0.2);
    }
}
