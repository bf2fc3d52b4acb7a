//! A scan in progress, with two main methods: [`observe`](Session::observe) and [`decide`](Session::decide).

mod agreement;
mod alignment;
mod config;
mod decision;
mod earlier;
mod goal;
#[cfg(test)]
mod instructions;
mod itinerary_progress;
mod known_scene;
mod known_situation;
mod replay;
mod report;
mod resolution;
mod scan_map;
mod seen_cells;
mod shown;
mod stop;
mod taken_frames;
mod views;

pub use config::SessionConfig;
pub use decision::{Decision, NextView, StopReason};
pub use report::{MapReport, StepReport};
pub use resolution::MultiResolutionConfig;
pub use shown::shown_object;
pub use stop::StopConfig;
pub use taken_frames::SetAside;
pub use views::Views;

use crate::diagnosis::{Suspicion, suspect, suspect_poses};
use crate::geometry::{Aabb, Plane, Pose};
use crate::map::{Occupancy, OccupancyMap, Snapshot};
use crate::motion::Trajectory;
use crate::object::{ObjectBox, OtherBody, Place, TableTops};
use crate::placement::{NextPlacement, ShownObject, Turn, TurnRefusal, next_placement};
use crate::planner::{Batch, BatchConfig, BatchView, EvenViews, Leg, Plan, Situation, ViewPlanner};
use crate::registration::{Registration, RegistrationMode};
use crate::sensor::{DepthRange, Frame, Intrinsics, SurfaceError};
use crate::view::ViewSpace;
use crate::{Cancel, Cancelled, Error};
use earlier::Earlier;
use itinerary_progress::ItineraryProgress;
use known_scene::{Added, KnownScene};
use known_situation::{known_situation, surroundings};
use seen_cells::SeenCells;
use shown::shown_on;
use std::collections::BTreeSet;
use taken_frames::TakenFrames;

/// A scan in progress: the map so far, the views taken, and the planner.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Aabb;
/// use nextview::planner::RandomViews;
/// use nextview::sensor::{DepthImage, Frame, Intrinsics};
/// use nextview::session::{Decision, Session, SessionConfig};
/// use nextview::view::generate;
///
/// let camera = Intrinsics::d435i();
/// let config = SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.1));
/// let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 50).unwrap();
/// let mut session = Session::new(config, camera, views, Box::new(RandomViews { seed: 1 })).unwrap();
/// while let Decision::Move(view) = session.decide().unwrap() {
///     let image = DepthImage::from_metres(640, 480, vec![f32::INFINITY; camera.n_pixels()]).unwrap();
///     session.observe(&Frame::new(image, camera, view.world_from_camera, 1.0).unwrap()).unwrap();
/// }
/// assert_eq!(session.visited().len(), 10);
/// ```
pub struct Session {
    config: SessionConfig,
    intrinsics: Intrinsics,
    views: Views,
    candidates: ViewSpace,
    planner: Box<dyn ViewPlanner>,
    scene: KnownScene,
    frames: TakenFrames,
    /// `None` if this is the first placement of the object.
    earlier: Option<Earlier>,
    /// Number of requested frames.
    n_taken: usize,
    visited: Vec<usize>,
    seen: SeenCells,
    /// Views that must not be proposed again.
    skipped: BTreeSet<usize>,
    /// By candidate, the robot's travel time; `None` if it cannot be reached at present.
    approaches: Option<Vec<Option<f64>>>,
    /// The decision since the last frame.
    decision: Option<Decision>,
    itinerary: ItineraryProgress,
    cancel: Cancel,
}

/// The session's state after joining the earlier placement.
struct Joined {
    turn: Result<Turn, TurnRefusal>,
    /// `None` if the turn is unknown.
    known: Option<(KnownScene, TakenFrames, Added)>,
}

impl Session {
    /// Returns a session for a camera with these optics. Fails if the configuration is out of range.
    pub fn new(
        config: SessionConfig,
        intrinsics: Intrinsics,
        views: impl Into<Views>,
        planner: Box<dyn ViewPlanner>,
    ) -> Result<Self, Error> {
        let views = views.into();
        config.check_with(&views)?;
        if let Some(goal) = config.goal {
            let SessionConfig { surface_error, voxel_size, depth_range, .. } = &config;
            goal::check_reachable(goal, surface_error, *voxel_size, &intrinsics, *depth_range)?;
        }
        let (scene, location) = KnownScene::new(&config)?;
        Ok(Self {
            scene,
            candidates: views.candidates(&location.unwrap_or_default(), config.depth_range),
            config,
            intrinsics,
            views,
            planner,
            seen: SeenCells::new(config.voxel_size),
            frames: TakenFrames::default(),
            earlier: None,
            n_taken: 0,
            visited: Vec::new(),
            skipped: BTreeSet::new(),
            approaches: None,
            decision: None,
            itinerary: ItineraryProgress::default(),
            cancel: Cancel::default(),
        })
    }

    /// Sets the flag that lets another thread cancel decisions and observations.
    pub fn with_cancel(self, cancel: Cancel) -> Self {
        Self { cancel, ..self }
    }

    /// Sets an earlier placement: the object was scanned before and has been turned since. As soon as the
    /// frames show [how](Self::turn), the earlier frames enter map and model, and planning continues from
    /// there.
    pub fn after(self, before: ShownObject) -> Self {
        Self { earlier: Some(Earlier { shown: before, turn: None }), ..self }
    }

    /// Adds a frame to the map, stores it, and counts the view as taken if one was decided on. With
    /// registration, it uses the corrected pose; a frame that cannot be aligned is [set
    /// aside](Self::set_aside), and enters the map once a later frame links it to the known surface.
    ///
    /// A [cancelled](Self::with_cancel) observation changes nothing: the frame can be observed again.
    pub fn observe(&mut self, frame: &Frame) -> Result<StepReport, Cancelled> {
        let planned_in = self.planning_voxel_size();
        let (mut scene, mut frames) = (self.scene.clone(), self.frames.clone());
        let mut added = scene.take_in(&self.config, frame, &mut frames, &self.cancel)?;
        let joined = self.join_earlier(&scene, &frames)?;
        let n_mapped = self.frames.mapped.len();
        (self.scene, self.frames) = (scene, frames);
        let Place { bounds, table } = self.scene.map.place();
        let top = table.map(|table| table.top);
        if added.apart.is_some() || added.is_as_given {
            self.seen = self.frames.seen_anew(SeenCells::new(self.config.voxel_size), bounds, top);
        } else {
            self.seen.add(&self.frames.mapped[n_mapped..], bounds, top);
        }
        if let Some(joined) = joined {
            self.adopt(joined, &mut added);
        }
        if let Some(location) = &added.moved {
            self.candidates = self.without_skipped(self.views.candidates(location, self.config.depth_range));
        }
        self.approaches = None;
        let taken = self.decision.take().and_then(Decision::next_view);
        self.n_taken += taken.is_some() as usize;
        self.visited.extend(taken.as_ref().and_then(|next| next.view));
        let is_planned = taken.as_ref().is_some_and(|next| next.choice.is_some());
        let voxel_size = if is_planned { planned_in } else { self.planning_voxel_size() };
        Ok(self.report(taken, voxel_size, added))
    }

    /// Aligns a frame to the surface known so far, without adding it. `None` if
    /// [registration](crate::registration) is off, and while no surface is known.
    pub fn locate(&self, frame: &Frame) -> Result<Option<Registration>, Cancelled> {
        self.scene.register(frame, &self.cancel)
    }

    /// Decides on the next view. Repeated calls before the next observation return the same decision, unless
    /// it was [cancelled](Self::with_cancel).
    ///
    /// Fails if the planner fails, which the library's own planners never do; the next call decides again.
    pub fn decide(&mut self) -> Result<Decision, Error> {
        if let Some(decision) = &self.decision {
            return Ok(decision.clone());
        }
        match self.decide_anew() {
            Ok(decision) => Ok(self.decision.insert(decision).clone()),
            Err(Error::Cancelled(_)) => Ok(Decision::Stop(StopReason::Cancelled)),
            Err(error) => Err(error),
        }
    }

    /// Returns the legs that would follow the decided next view if nothing were learned on the way: at most
    /// `n_legs`, within the view limit. They come from the planner's itinerary or, if it chooses one view at
    /// a time, from [`Batch::plan_after`]. Empty before an object is found.
    ///
    /// The session still decides again after the next view. Frames of the legs can be observed all the same.
    pub fn legs_after(&self, next: &NextView, n_legs: usize) -> Result<Vec<Leg>, Cancelled> {
        let n_views = n_legs.min(self.config.max_views.saturating_sub(self.n_taken + 1));
        let planned: Vec<Leg> = self.itinerary.rest().take(n_views).cloned().collect();
        let (Some(view), true) = (next.view, planned.is_empty() && n_views > 0) else { return Ok(planned) };
        let Some(snapshot) = self.scene.map.planning_snapshot(&self.cancel)? else { return Ok(planned) };
        let situation = Situation::new(&snapshot, &self.candidates, &self.intrinsics, &self.cancel);
        let approaches = self.approaches.as_deref();
        let (config, frames) = (&self.config, &self.frames.mapped);
        let situation = known_situation(situation, config, &self.scene, frames, &self.visited, approaches);
        let batch = Batch::new(BatchConfig { n_views, ..BatchConfig::default() });
        let views = batch.expect("at least one view").plan_after(&situation, view)?;
        Ok(views.iter().map(BatchView::leg).collect())
    }

    /// Excludes this view from all further decisions, for example because a robot cannot reach it. The
    /// current decision is discarded, so the next [decision](Self::decide) differs.
    ///
    /// A skipped [first view](SessionConfig::first_view) is replaced by the next higher number within reach,
    /// wrapping around after the highest. Numbers of nonexistent views are ignored.
    pub fn skip(&mut self, view: usize) {
        self.skipped.insert(view);
        self.candidates = self.without_skipped(self.candidates.clone());
        self.itinerary.skip(|given_up| given_up == view, self.decision.take().is_some());
    }

    /// Sets the robot's travel time to each candidate in seconds; `None` if it cannot be reached at present.
    /// Holds until the next frame, for all planners; those with a [movement
    /// cost](crate::planner::GreedyConfig::theta) use the times for it. The current decision is discarded.
    ///
    /// # Panics
    ///
    /// If the number of times differs from the number of candidates.
    pub fn set_approaches(&mut self, times: Vec<Option<f64>>) {
        assert_eq!(times.len(), self.candidates.len(), "a time for each candidate");
        self.itinerary.skip(|view| times[view].is_none(), self.decision.take().is_some());
        self.approaches = Some(times);
    }

    /// Returns the trajectory from the pose of the last frame to a view, such as the next one. It avoids the
    /// bounding sphere of the known part of the object and stays above its table. Before the first frame, the
    /// camera is assumed to be there already.
    ///
    /// Fails if it leaves [`Pose::REACH`].
    pub fn trajectory_to(&self, world_from_camera: &Pose) -> Result<Trajectory, Error> {
        let Some(last) = self.frames.places.last() else { return Ok(Trajectory::at(*world_from_camera)) };
        self.trajectory(last, world_from_camera)
    }

    /// Returns the trajectory from one view to another.
    pub fn trajectory(&self, from: &Pose, to: &Pose) -> Result<Trajectory, Error> {
        Trajectory::new(from, to, &surroundings(&self.scene), &self.config.motion)
    }

    /// Returns the map so far, in the finest voxels.
    pub fn map(&self) -> &OccupancyMap {
        self.scene.map.finest()
    }

    /// Returns the known state of the object's box, in the finest voxels; `None` before an object is found.
    pub fn snapshot(&self) -> Option<Snapshot> {
        self.scene.map.finest_snapshot(&Cancel::default()).expect("nobody cancels")
    }

    /// Returns the object's box, metres, without the part below its table; `None` before an object is found.
    pub fn bounds(&self) -> Option<Aabb> {
        self.scene.map.place().bounds
    }

    /// Returns the table under the object; `None` if there is none, or before it is found.
    pub fn table(&self) -> Option<Plane> {
        self.scene.map.place().table.map(|table| table.plane)
    }

    /// Returns the top of the table in each frame; `None` if there is no table, or before table and object
    /// are found.
    pub fn table_tops(&self) -> Option<TableTops> {
        self.scene.map.place().table_tops()
    }

    /// Returns the other bodies within a metre of an object whose box grows, nearest first; empty if the box
    /// is known. A body is at least 20 connected points with free space around most of their outline: walls
    /// and floors are not bodies.
    pub fn other_bodies(&self) -> Result<Vec<OtherBody>, Cancelled> {
        self.scene.locator.other_bodies(self.frames.of_now(), &self.cancel)
    }

    /// Returns the likely reason why the frames show nothing of the object, or do not fit together; `None` if
    /// all is well, or no reason is likely. See [`suspect`], and, for an object whose box grows among fixed
    /// views, [`suspect_poses`].
    pub fn suspicion(&self) -> Option<Suspicion> {
        let known = match self.config.object_box {
            ObjectBox::Known(bounds) => Some(bounds),
            ObjectBox::Growing => None,
        };
        let boundless = self.scene.is_box_too_large.then_some(Suspicion::Boundless);
        let frames = self.frames.of_now();
        let poses = || match (&self.views, known, frames.first()) {
            (Views::Fixed(views), None, Some(first)) => suspect_poses(first, views.poses()),
            _ => None,
        };
        // Aligned frames need not agree in the given poses.
        let apart = || match self.bounds() {
            Some(bounds) if self.config.registration.mode() == RegistrationMode::Off => {
                let voxel_size = self.config.voxel_size;
                let distance = agreement::apart(frames, bounds, voxel_size, &self.cancel).ok()??;
                Some(Suspicion::Apart { distance })
            }
            _ => None,
        };
        suspect(frames, known, self.config.depth_range).or_else(poses).or(boundless).or_else(apart)
    }

    /// Whether frames are aligned to the surface measured before. With [`RegistrationMode::Auto`], this
    /// begins once the given poses disagree, and ends if most frames cannot be aligned.
    pub fn aligns_frames(&self) -> bool {
        self.scene.alignment.is_active()
    }

    /// Returns the range of depths that the camera measures, metres.
    pub fn depth_range(&self) -> DepthRange {
        self.config.depth_range
    }

    /// Returns the random error of the camera.
    pub fn surface_error(&self) -> SurfaceError {
        self.config.surface_error
    }

    /// Returns the flag that cancels decisions and observations.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// Returns the edge of the voxels in which the next view is planned, metres.
    pub fn planning_voxel_size(&self) -> f64 {
        self.scene.map.planning_voxel_size()
    }

    /// Returns the frames in the map, in their final poses and in the order in which they entered it: all
    /// observed ones, oldest first, unless registration [set some aside](Self::set_aside), for a while or for
    /// good.
    pub fn frames(&self) -> &[Frame] {
        self.frames.of_now()
    }

    /// Returns the frames of the placement [before](Self::after), moved with the object, once its turn is
    /// known; empty until then. They show only the object.
    pub fn earlier_frames(&self) -> &[Frame] {
        &self.frames.mapped[..self.frames.n_earlier]
    }

    /// Returns how the object was turned since the placement [before](Self::after), or why that is unknown;
    /// `None` if there is none, and before the first frame.
    pub fn turn(&self) -> Option<Result<Turn, TurnRefusal>> {
        self.earlier.as_ref()?.turn
    }

    /// Returns the frames of both placements, the earlier ones first, moved with the object and reduced to
    /// it: a ray that ended on something else met nothing, or measured nothing if the object may be behind
    /// it. `None` unless the [turn](Self::turn) is known.
    pub fn frames_of_object(&self) -> Result<Option<Vec<Frame>>, Cancelled> {
        let earlier = self.earlier_frames();
        let now = if earlier.is_empty() { None } else { self.shown_in(&self.scene, &self.frames)? };
        Ok(now.map(|now| earlier.iter().chain(now.frames()).cloned().collect()))
    }

    /// Returns the placement that exposes most of the hidden surface; `None` if there is no table, before the
    /// object is found, and if hardly any surface would be exposed.
    pub fn next_placement(&self) -> Option<NextPlacement> {
        next_placement(&self.snapshot()?, self.table()?)
    }

    /// Returns, for each of [`frames`](Self::frames), its number among all observed frames, from 0.
    pub fn frame_numbers(&self) -> &[usize] {
        &self.frames.numbers
    }

    /// Returns the frames that could not be aligned so far, oldest first. They are in neither map nor model;
    /// each is tried again whenever another frame fits. Empty without registration, and if the aligned frames
    /// prove that the given poses are correct.
    pub fn set_aside(&self) -> &[SetAside] {
        &self.frames.set_aside
    }

    /// Returns the views taken so far, in order.
    pub fn visited(&self) -> &[usize] {
        &self.visited
    }

    /// Returns the view candidates in their current poses.
    pub fn views(&self) -> &ViewSpace {
        &self.candidates
    }

    /// Returns the turn of the object found in this scene of all frames, if it is new.
    fn join_earlier(&self, scene: &KnownScene, frames: &TakenFrames) -> Result<Option<Joined>, Cancelled> {
        let Some(earlier) = &self.earlier else { return Ok(None) };
        let Some(now) = self.shown_in(scene, frames)? else { return Ok(None) };
        let Some(turn) = earlier.find(&now, &self.cancel)? else { return Ok(None) };
        let join = |turn: Turn| {
            let frames = frames.after(earlier.frames(&turn.now_from_before));
            let (scene, added) = scene.anew(&self.config, &frames, &self.cancel)?;
            Ok((scene, frames, added))
        };
        Ok(Some(Joined { turn, known: turn.ok().map(join).transpose()? }))
    }

    /// Adopts the scene joined with the earlier placement.
    fn adopt(&mut self, Joined { turn, known }: Joined, added: &mut Added) {
        self.earlier.as_mut().expect("a turn is found of one").turn = Some(turn);
        let Some((scene, frames, joined)) = known else { return };
        (self.scene, self.frames) = (scene, frames);
        let Place { bounds, table } = self.scene.map.place();
        let earlier = &self.frames.mapped[..self.frames.n_earlier];
        self.seen.know(earlier, bounds, table.map(|table| table.top));
        added.moved = joined.moved.or(added.moved.take());
        added.report = joined.report;
    }

    /// Returns the object as shown by the frames of this placement, from their scene; `None` before it is
    /// found, and without a table.
    fn shown_in(&self, scene: &KnownScene, frames: &TakenFrames) -> Result<Option<ShownObject>, Cancelled> {
        let (snapshot, table) = (scene.map.finest_snapshot(&self.cancel)?, scene.map.place().table);
        let shown = |(snapshot, table)| shown_on(frames.of_now(), snapshot, table, &self.cancel);
        snapshot.zip(table).map(shown).transpose()
    }

    fn decide_anew(&mut self) -> Result<Decision, Error> {
        self.cancel.check()?;
        if let Some((view, world_from_camera)) = self.first_view() {
            return Ok(Decision::go_to(view, world_from_camera, Plan::default()));
        }
        if self.n_taken >= self.config.max_views {
            return Ok(Decision::Stop(StopReason::ViewLimit));
        }
        if self.scene.is_box_too_large {
            return Ok(Decision::Stop(StopReason::BoxTooLarge));
        }
        if self.scene.map.is_finest() && self.planner.seeks_surface() && self.has_stalled() {
            return Ok(Decision::Stop(StopReason::NoProgress));
        }
        loop {
            let Some(snapshot) = self.scene.map.planning_snapshot(&self.cancel)? else {
                return Ok(Decision::Stop(StopReason::NoObject));
            };
            if self.is_converged(&snapshot)? {
                return Ok(Decision::Stop(StopReason::Converged));
            }
            let plan = self.plan(&snapshot)?;
            if let Some(reason) = self.reason_to_stop(&plan) {
                return Ok(Decision::Stop(reason));
            }
            if let Some(view) = plan.choice.as_ref().map(|choice| choice.view) {
                self.itinerary.depart(&snapshot);
                return Ok(Decision::go_to(Some(view), self.candidates.pose(view), plan));
            }
            if self.scene.map.is_finest() {
                return Ok(Decision::Stop(self.reason_for_no_choice()));
            }
            self.scene.map.refine(&self.frames.mapped, &self.cancel)?; // finer voxels may show more than coarse ones
        }
    }

    /// Whether the last views together hardly showed or improved anything.
    fn has_stalled(&self) -> bool {
        let n = StopConfig::PROGRESS_VIEWS;
        let is_little = |share: f64| share < self.config.stop.progress;
        let quality = self.scene.quality.as_ref();
        self.seen.progress(n).is_some_and(is_little)
            && quality.and_then(|quality| quality.progress(n)).is_none_or(is_little)
    }

    /// Returns number and pose of the first view, before it is taken.
    fn first_view(&self) -> Option<(Option<usize>, Pose)> {
        match &self.views {
            Views::Fixed(views) if self.n_taken == 0 => {
                let view = self.first_candidate()?;
                Some((Some(view), views.pose(view)))
            }
            Views::Fixed(_) => None,
            Views::Following { first, .. } => self.frames.places.is_empty().then_some((None, *first)),
        }
    }

    /// Returns the configured first view or, if that is skipped or out of reach, the next one within reach,
    /// if any.
    fn first_candidate(&self) -> Option<usize> {
        let first = self.config.first_view;
        let can_go = |view: usize| self.approaches.as_ref().is_none_or(|times| times[view].is_some());
        if !self.skipped.contains(&first) && can_go(first) {
            return Some(first);
        }
        let can_be_first = |view: usize| self.candidates.is_within_reach(view) && can_go(view);
        (first..self.candidates.len()).chain(0..first).find(|&view| can_be_first(view))
    }

    fn without_skipped(&self, views: ViewSpace) -> ViewSpace {
        views.only(|view| !self.skipped.contains(&view))
    }

    fn is_converged(&self, snapshot: &Snapshot) -> Result<bool, Cancelled> {
        let Some(q_thresh) = self.config.stop.entropy_share.filter(|_| self.scene.map.is_finest()) else {
            return Ok(false);
        };
        Ok(snapshot.entropy_share_unless(&self.cancel)? < q_thresh)
    }

    /// Returns the reason not to take the plan's next view, if any.
    fn reason_to_stop(&self, plan: &Plan) -> Option<StopReason> {
        let StopConfig { completeness, path_length, .. } = self.config.stop;
        let outlook = plan.outlook.as_ref().filter(|_| self.scene.map.is_finest());
        if outlook.zip(completeness).is_some_and(|(outlook, enough)| outlook.completeness() >= enough) {
            return Some(StopReason::Complete);
        }
        let choice = plan.choice.as_ref()?;
        let share_at_goal = self.scene.quality.as_ref().map(goal::Quality::share_at_goal);
        let little = self.config.stop.little_gain(share_at_goal);
        if outlook.is_some_and(|outlook| outlook.gain() < little) {
            return Some(StopReason::LittleToGain);
        }
        let is_too_long = path_length.is_some_and(|limit| self.path_length_with(choice.view) > limit);
        is_too_long.then_some(StopReason::PathLimit)
    }

    /// Returns the reason why no view was chosen: none is within reach, or none gains anything.
    fn reason_for_no_choice(&self) -> StopReason {
        let is_open = |(view, time): (usize, &Option<f64>)| time.is_some() && !self.visited.contains(&view);
        match &self.approaches {
            Some(times) if !times.iter().enumerate().any(is_open) => StopReason::OutOfReach,
            _ => StopReason::NothingToGain,
        }
    }

    /// Returns the length of the straight path through all camera positions and on to a view, metres.
    fn path_length_with(&self, view: usize) -> f64 {
        let next = self.candidates.pose(view).translation();
        let last = self.frames.places.last().map(|last| last.translation().distance(next));
        self.legs().sum::<f64>() + last.unwrap_or(0.0)
    }

    /// Returns the straight distances between consecutive camera positions so far, metres.
    fn legs(&self) -> impl DoubleEndedIterator<Item = f64> {
        self.frames.places.windows(2).map(|pair| pair[0].translation().distance(pair[1].translation()))
    }

    /// Returns the next view of the itinerary, or else a new plan.
    fn plan(&mut self, snapshot: &Snapshot) -> Result<Plan, Error> {
        if let Some(choice) = self.itinerary.next(snapshot) {
            return Ok(Plan { choice: Some(choice), ..Plan::default() });
        }
        let situation = Situation::new(snapshot, &self.candidates, &self.intrinsics, &self.cancel);
        let approaches = self.approaches.as_deref();
        let (config, frames) = (&self.config, &self.frames.mapped);
        let situation = known_situation(situation, config, &self.scene, frames, &self.visited, approaches);
        let mut plan = self.planner.plan(&situation)?;
        // While nothing of the box was seen, as after a first image without depths, a planner may find no
        // view worthwhile; one from elsewhere is.
        if plan.choice.is_none() && self.scene.map.is_finest() && snapshot.count(Occupancy::Occupied) == 0 {
            plan = EvenViews.plan(&situation)?;
        }
        self.itinerary.follow(plan.itinerary.take());
        Ok(plan)
    }

    fn report(&self, taken: Option<NextView>, voxel_size: f64, added: Added) -> StepReport {
        let number = self.frames.places.len() - 1;
        let Place { bounds, table } = self.scene.map.place();
        StepReport {
            step: self.n_taken,
            view: taken.as_ref().and_then(|next| next.view),
            world_from_camera: self.frames.places[number],
            registration: added.registration,
            apart: added.apart,
            is_as_given: added.is_as_given,
            is_set_aside: self.frames.set_aside.iter().any(|waiting| waiting.number == number),
            recovered: added.recovered,
            outlook: taken.as_ref().and_then(|next| next.outlook.clone()),
            choice: taken.and_then(|next| next.choice),
            travel: self.legs().next_back().unwrap_or(0.0),
            voxel_size,
            bounds,
            table: table.map(|table| table.plane),
            share_at_goal: added.share_at_goal,
            update: added.update,
            map: added.report,
        }
    }
}
