//! A scan in progress: two verbs, [`observe`](Session::observe) and [`decide`](Session::decide).

mod alignment;
mod config;
mod course;
mod object_box;
mod object_points;
mod report;
mod resolution;
mod scan_map;
mod table;
mod views;

pub use config::{SessionConfig, StopConfig};
pub use object_box::ObjectBox;
pub use report::{MapReport, StepReport};
pub use resolution::MultiResolution;
pub use table::Table;
pub use views::Views;

use crate::Error;
use crate::geometry::{Aabb, Pose};
use crate::map::{MapUpdate, OccupancyMap, Snapshot};
use crate::motion::{Surroundings, Way};
use crate::planner::{Choice, FlowSummary, Outlook, Plan, Situation, ViewPlanner};
use crate::registration::{KnownSurface, Registration};
use crate::sensor::{Frame, Intrinsics};
use crate::view::ViewSpace;
use alignment::Alignment;
use course::Course;
use object_box::{Location, Locator};
use scan_map::{MapRules, Place, ScanMap};
use serde::{Deserialize, Serialize};

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
/// while let Decision::Move(view) = session.decide() {
///     let image = DepthImage::from_metres(640, 480, vec![f32::INFINITY; camera.n_pixels()]).unwrap();
///     session.observe(&Frame::new(image, camera, view.world_from_camera, 1.0).unwrap());
/// }
/// assert_eq!(session.visited().len(), 10);
/// ```
pub struct Session {
    config: SessionConfig,
    intrinsics: Intrinsics,
    views: Views,
    candidates: ViewSpace,
    planner: Box<dyn ViewPlanner>,
    locator: Locator,
    map: ScanMap,
    alignment: Alignment,
    /// The box that was found is larger than the memory limit allows, and was not gone over to.
    is_box_too_large: bool,
    frames: Vec<Frame>,
    /// Number of frames that were asked for.
    n_taken: usize,
    visited: Vec<usize>,
    /// V_global of every plan so far.
    history: Vec<Vec<u32>>,
    /// What was decided since the last frame.
    decision: Option<Decision>,
    course: Course,
}

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// Go there and observe.
    Move(NextView),
    /// The scan is over.
    Stop(StopReason),
}

/// The next best view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextView {
    /// Its number in the view space; none for a first view that is no candidate.
    pub view: Option<usize>,
    /// Where the camera should stand.
    pub world_from_camera: Pose,
    /// Why it was chosen; none for the first view, which is given.
    pub choice: Option<Choice>,
    /// The flow behind the choice, for planners that solve one.
    pub flow: Option<FlowSummary>,
    /// What the planner expects of the view and of all that could follow, for planners that tell.
    pub outlook: Option<Outlook>,
}

/// Why a scan ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// As many views were taken as allowed.
    ViewLimit,
    /// The entropy in the box fell below the stated share: the paper's eq. (9).
    Converged,
    /// No candidate gains anything.
    NothingToGain,
    /// As much of the surface as asked for is estimated to have been seen.
    Complete,
    /// The next view is expected to add less than asked for.
    LittleToGain,
    /// The way to the next view would make the path longer than allowed.
    PathLimit,
    /// The time allowed is over. A session reads no clock: whoever runs it tells.
    TimeLimit,
    /// There is no box to plan in: no frame shows an object yet, or the known box lies inside the table. After another
    /// frame, taken from elsewhere, the scan may go on.
    NoObject,
    /// The box around what hangs together with the object needs more memory than allowed: a table or wall that it touches?
    BoxTooLarge,
}

impl Session {
    /// A scan by a camera with these optics; fails on a configuration out of range.
    pub fn new(
        config: SessionConfig,
        intrinsics: Intrinsics,
        views: impl Into<Views>,
        planner: Box<dyn ViewPlanner>,
    ) -> Result<Self, Error> {
        let views = views.into();
        config.check(&views)?;
        let SessionConfig { voxel_size, sensor_model, rays, background, .. } = config;
        let mut session = Self {
            locator: Locator::new(&config),
            map: ScanMap::new(MapRules { voxel_size, sensor_model, rays, background }, Place::default()),
            alignment: Alignment::new(config.registration.map(KnownSurface::new).transpose()?),
            candidates: views.candidates(&Location::default()),
            config,
            intrinsics,
            views,
            planner,
            is_box_too_large: false,
            frames: Vec::new(),
            n_taken: 0,
            visited: Vec::new(),
            history: Vec::new(),
            decision: None,
            course: Course::default(),
        };
        session.locate();
        Ok(session)
    }

    /// Writes a frame into the map, keeps it, and, if a view was decided on, counts it as taken. With registration, all that
    /// is done with the corrected pose.
    pub fn observe(&mut self, frame: &Frame) -> StepReport {
        let planned_in = self.map.planning_voxel_size();
        let registration = self.alignment.register(frame, self.bounds());
        let pose = registration.map_or(frame.world_from_camera(), |found| found.world_from_camera);
        self.frames.push(frame.clone().with_pose(pose));
        self.locate();
        let (bounds, frame) = (self.bounds(), self.frames.last().expect("a frame was added"));
        self.alignment.remember(frame, bounds, registration);
        let update = self.map.integrate(frame);
        self.refine_what_is_known();
        let taken = self.decision.take().and_then(Decision::next_view);
        self.n_taken += taken.is_some() as usize;
        self.visited.extend(taken.and_then(|next| next.view));
        let is_planned = taken.is_some_and(|next| next.choice.is_some());
        let voxel_size = if is_planned { planned_in } else { self.map.planning_voxel_size() };
        self.report(taken, voxel_size, update, registration)
    }

    /// Decides on the next view. Asked again before the next observation, the answer is the same.
    pub fn decide(&mut self) -> Decision {
        let decision = self.decision.unwrap_or_else(|| self.decide_anew());
        self.decision = Some(decision);
        decision
    }

    /// The way from where the last frame was taken to a view, such as the next one: around the ball around what is known of
    /// the object, and above its table. Before the first frame, the camera is there already.
    pub fn way_to(&self, world_from_camera: &Pose) -> Way {
        let Some(last) = self.frames.last() else { return Way::at(*world_from_camera) };
        let Place { bounds: object, table } = self.map.place();
        let surroundings = Surroundings { object, floor: table.map(|table| table.floor()) };
        let way = Way::new(&last.world_from_camera(), world_from_camera, &surroundings, &self.config.motion);
        way.expect("the configuration was checked, a box that is planned in is finite, and so are cameras' distances")
    }

    /// The map so far, in the finest voxels.
    pub fn map(&self) -> &OccupancyMap {
        self.map.finest()
    }

    /// What is known of the box around the object, in the finest voxels; none before an object was found.
    pub fn snapshot(&self) -> Option<Snapshot> {
        self.map.finest_snapshot()
    }

    /// The box around the object, metres, without what is below its table; none before an object was found.
    pub fn bounds(&self) -> Option<Aabb> {
        self.map.place().bounds
    }

    /// Edge of the voxels that the next view is planned in, metres.
    pub fn planning_voxel_size(&self) -> f64 {
        self.map.planning_voxel_size()
    }

    /// The frames observed so far, oldest first.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The views taken so far, in order.
    pub fn visited(&self) -> &[usize] {
        &self.visited
    }

    /// The view candidates as they stand now.
    pub fn views(&self) -> &ViewSpace {
        &self.candidates
    }

    fn decide_anew(&mut self) -> Decision {
        if let Some((view, world_from_camera)) = self.first_view() {
            return go_to(view, world_from_camera, &Plan::default());
        }
        if self.n_taken >= self.config.stop.max_views {
            return Decision::Stop(StopReason::ViewLimit);
        }
        if self.is_box_too_large {
            return Decision::Stop(StopReason::BoxTooLarge);
        }
        loop {
            let Some(snapshot) = self.map.planning_snapshot() else {
                return Decision::Stop(StopReason::NoObject);
            };
            if self.is_converged(&snapshot) {
                return Decision::Stop(StopReason::Converged);
            }
            let plan = self.plan(&snapshot);
            if let Some(reason) = self.reason_to_stop(&plan) {
                return Decision::Stop(reason);
            }
            if let Some(choice) = plan.choice {
                self.course.depart(&snapshot);
                return go_to(Some(choice.view), self.candidates.pose(choice.view), &plan);
            }
            if self.map.is_finest() {
                return Decision::Stop(StopReason::NothingToGain);
            }
            self.map.refine(&self.frames); // what coarse voxels do not show, finer ones may
        }
    }

    /// Number and pose of the first view, before it was taken.
    fn first_view(&self) -> Option<(Option<usize>, Pose)> {
        let view = self.config.first_view;
        match &self.views {
            Views::Fixed(views) => (self.n_taken == 0).then(|| (Some(view), views.pose(view))),
            Views::Following { first, .. } => self.frames.is_empty().then_some((None, *first)),
        }
    }

    /// Goes over to the box that all frames tell, the last of which is not mapped yet, unless it is too large.
    fn locate(&mut self) {
        let location = self.locator.locate(&self.frames);
        let block = location.place.bounds.map(|bounds| self.config.block(&bounds));
        self.is_box_too_large = matches!(block, Some(Err(Error::TooLarge { .. })));
        if location.place == self.map.place() || self.is_box_too_large {
            return;
        }
        let known = &self.frames[..self.frames.len().saturating_sub(1)];
        let is_first_box = self.map.place().bounds.is_none();
        self.candidates = self.views.candidates(&location);
        self.map.move_to(location.place, known);
        if let (true, Some(rule), Some(bounds)) =
            (is_first_box, self.config.multi_resolution, location.place.bounds)
        {
            self.map.plan_in(rule.n_halvings(self.config.voxel_size, bounds.longest_side()), known);
        }
    }

    /// Halves the voxels that planning uses as long as the map in them is known well enough: algorithm 1, eq. (9).
    fn refine_what_is_known(&mut self) {
        let Some(rule) = self.config.multi_resolution else { return };
        let is_known = |map: &ScanMap| {
            let share = map.planning_snapshot().map(|snapshot| snapshot.entropy_share());
            share.is_some_and(|share| share < rule.q_thresh)
        };
        while !self.map.is_finest() && is_known(&self.map) {
            self.map.refine(&self.frames);
        }
    }

    fn is_converged(&self, snapshot: &Snapshot) -> bool {
        let share = self.config.stop.entropy_share;
        self.map.is_finest() && share.is_some_and(|q_thresh| snapshot.entropy_share() < q_thresh)
    }

    /// Whether the plan's next view is not worth the while.
    fn reason_to_stop(&self, plan: &Plan) -> Option<StopReason> {
        let StopConfig { completeness, expected_gain, path_length, .. } = self.config.stop;
        let outlook = plan.outlook.filter(|_| self.map.is_finest());
        if outlook.zip(completeness).is_some_and(|(outlook, enough)| outlook.completeness() >= enough) {
            return Some(StopReason::Complete);
        }
        let choice = plan.choice?;
        if outlook.zip(expected_gain).is_some_and(|(outlook, least)| outlook.gain() < least) {
            return Some(StopReason::LittleToGain);
        }
        let is_too_long = path_length.is_some_and(|limit| self.path_length_with(choice.view) > limit);
        is_too_long.then_some(StopReason::PathLimit)
    }

    /// Length of the straight path through the places of all frames and on to a view, metres.
    fn path_length_with(&self, view: usize) -> f64 {
        let next = self.candidates.pose(view).translation();
        let last = self.frames.last().map(|frame| frame.world_from_camera().translation().distance(next));
        self.legs().sum::<f64>() + last.unwrap_or(0.0)
    }

    /// Straight distances between the places of the frames so far, metres.
    fn legs(&self) -> impl DoubleEndedIterator<Item = f64> {
        let position = |frame: &Frame| frame.world_from_camera().translation();
        self.frames.windows(2).map(move |pair| position(&pair[0]).distance(position(&pair[1])))
    }

    /// The next view of the itinerary, or else a new plan.
    fn plan(&mut self, snapshot: &Snapshot) -> Plan {
        if let Some(choice) = self.course.next(snapshot) {
            return Plan { choice: Some(choice), ..Plan::default() };
        }
        let mut plan = self.planner.plan(&self.situation(snapshot));
        self.course.follow(plan.itinerary.take());
        if plan.choice.is_some() {
            self.history.push(plan.optimal_views.clone());
        }
        plan
    }

    fn situation<'a>(&'a self, snapshot: &'a Snapshot) -> Situation<'a> {
        let Self { frames, candidates: views, intrinsics, visited, history, .. } = self;
        let finest_voxel_size = self.config.voxel_size;
        Situation { snapshot, frames, views, intrinsics, visited, history, finest_voxel_size }
    }

    fn report(
        &self,
        taken: Option<NextView>,
        voxel_size: f64,
        update: MapUpdate,
        registration: Option<Registration>,
    ) -> StepReport {
        let frame = self.frames.last().expect("a report follows a frame");
        let Place { bounds, table } = self.map.place();
        StepReport {
            step: self.n_taken,
            view: taken.and_then(|next| next.view),
            world_from_camera: frame.world_from_camera(),
            registration,
            choice: taken.and_then(|next| next.choice),
            flow: taken.and_then(|next| next.flow),
            outlook: taken.and_then(|next| next.outlook),
            travel: self.legs().next_back().unwrap_or(0.0),
            voxel_size,
            bounds,
            table: table.map(|table| table.plane),
            update,
            map: self.snapshot().map_or_else(MapReport::default, |snapshot| MapReport::new(&snapshot)),
        }
    }
}

impl Decision {
    fn next_view(self) -> Option<NextView> {
        match self {
            Self::Move(next) => Some(next),
            Self::Stop(_) => None,
        }
    }
}

fn go_to(view: Option<usize>, world_from_camera: Pose, plan: &Plan) -> Decision {
    let Plan { choice, flow, outlook, .. } = *plan;
    Decision::Move(NextView { view, world_from_camera, choice, flow, outlook })
}
