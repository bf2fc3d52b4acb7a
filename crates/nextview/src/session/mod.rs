//! A scan in progress: two verbs, [`observe`](Session::observe) and [`decide`](Session::decide).

mod config;
mod report;

pub use config::{SessionConfig, StopConfig};
pub use report::{MapReport, StepReport};

use crate::Error;
use crate::geometry::{Lattice, Pose, VoxelBlock};
use crate::map::{Integration, MapUpdate, OccupancyMap, Snapshot};
use crate::planner::{Choice, FlowSummary, Plan, Situation, ViewPlanner};
use crate::sensor::{Frame, Intrinsics};
use crate::view::ViewSpace;
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
    views: ViewSpace,
    planner: Box<dyn ViewPlanner>,
    block: VoxelBlock,
    map: OccupancyMap,
    frames: Vec<Frame>,
    visited: Vec<usize>,
    /// V_global of every plan so far.
    history: Vec<Vec<u32>>,
    pending: Option<NextView>,
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
    /// Its number in the view space.
    pub view: usize,
    /// Where the camera should stand.
    pub world_from_camera: Pose,
    /// Why it was chosen; none for the first view, which is given.
    pub choice: Option<Choice>,
    /// The flow behind the choice, for planners that solve one.
    pub flow: Option<FlowSummary>,
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
}

impl Session {
    /// A scan of the object in the configured box by a camera with these optics; fails on a configuration out of range.
    pub fn new(
        config: SessionConfig,
        intrinsics: Intrinsics,
        views: ViewSpace,
        planner: Box<dyn ViewPlanner>,
    ) -> Result<Self, Error> {
        let block = config.block(&views)?;
        let map = OccupancyMap::new(Lattice::new(config.voxel_size)?, config.sensor_model)?;
        let (frames, visited, history) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Self { config, intrinsics, views, planner, block, map, frames, visited, history, pending: None })
    }

    /// Writes a frame into the map, keeps it, and, if a view was decided on, counts it as taken.
    pub fn observe(&mut self, frame: &Frame) -> StepReport {
        let SessionConfig { rays, background, .. } = self.config;
        let update = self.map.integrate(frame, &Integration { rays, background, region: Some(self.block) });
        self.frames.push(frame.clone());
        let taken = self.pending.take();
        self.visited.extend(taken.map(|next| next.view));
        self.report(frame, taken, update)
    }

    /// Decides on the next view. Asked again before the next observation, the answer is the same.
    pub fn decide(&mut self) -> Decision {
        if let Some(next) = self.pending {
            return Decision::Move(next);
        }
        if self.visited.is_empty() {
            return self.go_to(self.config.first_view, &Plan::default());
        }
        if self.visited.len() >= self.config.stop.max_views {
            return Decision::Stop(StopReason::ViewLimit);
        }
        let snapshot = self.snapshot();
        if self.config.stop.entropy_share.is_some_and(|q_thresh| snapshot.entropy_share() < q_thresh) {
            return Decision::Stop(StopReason::Converged);
        }
        let plan = self.planner.plan(&self.situation(&snapshot));
        match plan.choice {
            Some(choice) => {
                self.history.push(plan.optimal_views.clone());
                self.go_to(choice.view, &plan)
            }
            None => Decision::Stop(StopReason::NothingToGain),
        }
    }

    /// The map so far.
    pub fn map(&self) -> &OccupancyMap {
        &self.map
    }

    /// What is known of the box around the object.
    pub fn snapshot(&self) -> Snapshot {
        self.map.snapshot(self.block)
    }

    /// The frames observed so far, oldest first.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The views taken so far, in order.
    pub fn visited(&self) -> &[usize] {
        &self.visited
    }

    /// The view candidates.
    pub fn views(&self) -> &ViewSpace {
        &self.views
    }

    fn situation<'a>(&'a self, snapshot: &'a Snapshot) -> Situation<'a> {
        let Self { frames, views, intrinsics, visited, history, .. } = self;
        Situation { snapshot, frames, views, intrinsics, visited, history }
    }

    fn go_to(&mut self, view: usize, plan: &Plan) -> Decision {
        let world_from_camera = self.views.pose(view);
        let next = NextView { view, world_from_camera, choice: plan.choice, flow: plan.flow };
        self.pending = Some(next);
        Decision::Move(next)
    }

    fn report(&self, frame: &Frame, taken: Option<NextView>, update: MapUpdate) -> StepReport {
        StepReport {
            step: self.visited.len(),
            view: taken.map(|next| next.view),
            world_from_camera: frame.world_from_camera(),
            choice: taken.and_then(|next| next.choice),
            flow: taken.and_then(|next| next.flow),
            update,
            map: MapReport::new(&self.snapshot()),
        }
    }
}
