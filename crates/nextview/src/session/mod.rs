//! A scan in progress, with two main methods: [`observe`](Session::observe) and [`decide`](Session::decide).

mod alignment;
mod config;
mod decision;
mod earlier;
mod ending;
mod goal;
#[cfg(test)]
mod instructions;
mod itinerary_progress;
mod known;
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

use crate::geometry::Pose;
use crate::map::{Occupancy, Snapshot};
use crate::object::Place;
use crate::placement::ShownObject;
use crate::planner::{Fallback, Leg, Plan, Situation, ViewPlanner};
use crate::sensor::{Frame, Intrinsics};
use crate::view::ViewSpace;
use crate::{Cancel, Cancelled, Error};
use earlier::Earlier;
use itinerary_progress::ItineraryProgress;
use known_scene::{Added, KnownScene};
use known_situation::known_situation;
use std::collections::BTreeSet;

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
    fallback: Fallback,
    scene: KnownScene,
    /// Number of requested frames.
    n_taken: usize,
    visited: Vec<usize>,
    /// Views that must not be proposed again.
    skipped: BTreeSet<usize>,
    /// By candidate, the robot's travel time; `None` if it cannot be reached at present.
    approaches: Option<Vec<Option<f64>>>,
    /// The decision since the last frame.
    decision: Option<Decision>,
    itinerary: ItineraryProgress,
    cancel: Cancel,
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
            fallback: Fallback::default(),
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

    /// Sets the planners that answer where the session's own has nothing to say. Default:
    /// [`Fallback::default`].
    pub fn with_fallback(self, fallback: Fallback) -> Self {
        Self { fallback, ..self }
    }

    /// Sets an earlier placement: the object was scanned before and has been turned since. As soon as the
    /// frames show [how](Self::turn), the earlier frames enter map and model, and planning continues from
    /// there.
    pub fn after(mut self, before: ShownObject) -> Self {
        self.scene.earlier = Some(Earlier { shown: before.into(), turn: None });
        self
    }

    /// Adds a frame to the map, stores it, and counts the view as taken if one was decided on. With
    /// registration, it uses the corrected pose; a frame that cannot be aligned is [set
    /// aside](Self::set_aside), and enters the map once a later frame links it to the known surface.
    ///
    /// A [cancelled](Self::with_cancel) observation changes nothing: the frame can be observed again.
    pub fn observe(&mut self, frame: &Frame) -> Result<StepReport, Cancelled> {
        let planned_in = self.planning_voxel_size();
        let (scene, added) = self.scene.with_frame(&self.config, frame, &self.cancel)?;
        self.scene = scene;
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

    fn decide_anew(&mut self) -> Result<Decision, Error> {
        self.cancel.check()?;
        if let Some((view, world_from_camera)) = self.first_view() {
            return Ok(Decision::go_to(view, world_from_camera, Plan::default()));
        }
        if let Some(reason) = self.stops_before_planning() {
            return Ok(Decision::Stop(reason));
        }
        loop {
            let Some(snapshot) = self.scene.map.planning_snapshot(&self.cancel)? else {
                return Ok(Decision::Stop(StopReason::NoObject));
            };
            if self.is_converged(&snapshot)? {
                return Ok(Decision::Stop(StopReason::Converged));
            }
            let plan = self.plan(&snapshot)?;
            if let Some(reason) = self.stops_after(&plan) {
                return Ok(Decision::Stop(reason));
            }
            if let Some(view) = plan.choice.as_ref().map(|choice| choice.view) {
                self.itinerary.depart(&snapshot);
                return Ok(Decision::go_to(Some(view), self.candidates.pose(view), plan));
            }
            // Finer voxels may show more than coarse ones.
            self.scene.map.refine(&self.scene.frames.mapped, &self.cancel)?;
        }
    }

    /// Returns the next view of the itinerary, or else a new plan.
    fn plan(&mut self, snapshot: &Snapshot) -> Result<Plan, Error> {
        if let Some(choice) = self.itinerary.next(snapshot) {
            return Ok(Plan { choice: Some(choice), ..Plan::default() });
        }
        let situation = Situation::new(snapshot, &self.candidates, &self.intrinsics, &self.cancel);
        let approaches = self.approaches.as_deref();
        let situation = known_situation(situation, &self.config, &self.scene, &self.visited, approaches);
        let mut plan = self.planner.plan(&situation)?;
        // While nothing of the box was seen, as after a first image without depths, a planner may find no
        // view worthwhile; one from elsewhere is.
        if plan.choice.is_none() && self.scene.map.is_finest() && snapshot.count(Occupancy::Occupied) == 0 {
            plan = self.fallback.view.plan(&situation)?;
        }
        self.itinerary.follow(plan.itinerary.take());
        Ok(plan)
    }

    /// Returns the legs that would follow the decided next view if nothing were learned on the way: at most
    /// `n_legs`, within the view limit. They come from the planner's itinerary or, if it chooses one view at
    /// a time, from the [fallback](Self::with_fallback). Empty before an object is found.
    ///
    /// The session still decides again after the next view. Frames of the legs can be observed all the same.
    pub fn legs_after(&self, next: &NextView, n_legs: usize) -> Result<Vec<Leg>, Cancelled> {
        let n_views = n_legs.min(self.config.max_views.saturating_sub(self.n_taken + 1));
        let planned: Vec<Leg> = self.itinerary.rest().take(n_views).cloned().collect();
        let (Some(view), true) = (next.view, planned.is_empty() && n_views > 0) else { return Ok(planned) };
        let Some(snapshot) = self.scene.map.planning_snapshot(&self.cancel)? else { return Ok(planned) };
        let situation = Situation::new(&snapshot, &self.candidates, &self.intrinsics, &self.cancel);
        let approaches = self.approaches.as_deref();
        let situation = known_situation(situation, &self.config, &self.scene, &self.visited, approaches);
        (self.fallback.legs)(&situation, view, n_views)
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

    /// Returns number and pose of the first view, before it is taken.
    fn first_view(&self) -> Option<(Option<usize>, Pose)> {
        match &self.views {
            Views::Fixed(views) if self.n_taken == 0 => {
                let view = self.first_candidate()?;
                Some((Some(view), views.pose(view)))
            }
            Views::Fixed(_) => None,
            Views::Following { first, .. } => self.scene.frames.places.is_empty().then_some((None, *first)),
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

    /// Returns the straight distances between consecutive camera positions so far, metres.
    fn legs(&self) -> impl DoubleEndedIterator<Item = f64> {
        self.scene.frames.places.windows(2).map(|pair| pair[0].translation().distance(pair[1].translation()))
    }

    fn report(&self, taken: Option<NextView>, voxel_size: f64, added: Added) -> StepReport {
        let number = self.scene.frames.places.len() - 1;
        let Place { bounds, table } = self.scene.map.place();
        StepReport {
            step: self.n_taken,
            view: taken.as_ref().and_then(|next| next.view),
            world_from_camera: self.scene.frames.places[number],
            registration: added.registration,
            apart: added.apart,
            is_as_given: added.is_as_given,
            is_set_aside: self.scene.frames.set_aside.iter().any(|waiting| waiting.number == number),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use crate::planner::{Choice, InOrder};
    use crate::sensor::DepthImage;
    use crate::view::generate::fibonacci_sphere;
    use glam::DVec3;

    struct NoChoice;

    impl ViewPlanner for NoChoice {
        fn plan(&mut self, _: &Situation<'_>) -> Result<Plan, Error> {
            Ok(Plan::default())
        }
    }

    fn leg_to_sum(_: &Situation<'_>, view: usize, n_views: usize) -> Result<Vec<Leg>, Cancelled> {
        Ok(vec![Leg { choice: Choice::new(view + n_views, 0.0), expected: 1.0 }])
    }

    #[test]
    fn the_fallback_answers_where_the_planner_has_nothing_to_say() {
        let camera = Intrinsics::d435i();
        let config = SessionConfig::new(0.02, Aabb::cube(DVec3::ZERO, 0.1));
        let views = fibonacci_sphere(DVec3::ZERO, 0.4, 10).unwrap();
        let mut session = Session::new(config, camera, views, Box::new(NoChoice))
            .unwrap()
            .with_fallback(Fallback { view: Box::new(InOrder), legs: leg_to_sum });
        let Decision::Move(first) = session.decide().unwrap() else { panic!("the first view is given") };
        let image = DepthImage::from_metres(640, 480, vec![f32::NAN; camera.n_pixels()]).unwrap();
        let frame = Frame::new(image, camera, first.world_from_camera, 1.0).unwrap();
        session.observe(&frame).unwrap();
        let Decision::Move(next) = session.decide().unwrap() else {
            panic!("another view may show something")
        };
        assert_eq!(next.view, Some(1));
        assert_eq!(session.legs_after(&next, 3).unwrap()[0].choice.view, 4);
    }
}
