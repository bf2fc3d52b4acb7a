use super::Slips;
use super::camera::look_from;
use super::flow::{Ties, flow_gains, in_flow, optimal_views};
use super::gain::Qualities;
use super::map::{Knowledge, Map};
use super::rays::{PlanningRays, RayCaster};
use super::recording::{N_SCANS, RECORDED_VIEWS, RecordedRun};
use super::sensor::VirtualCamera;
use crate::Outcome;
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use nextview::sensor::Intrinsics;
use std::time::{Duration, Instant};

/// The object in front of the camera.
pub struct ScannedObject {
    /// The recorded run.
    pub recording: RecordedRun,
    camera: VirtualCamera,
    intrinsics: Intrinsics,
}

/// A rule for choosing views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChoiceRule {
    /// The views of the recorded run.
    Recorded,
    /// Random views, from a draw with this number.
    Random(u64),
    /// The views of eq. (7).
    MaxFlow {
        /// Gamma of eq. (6).
        gamma: f64,
        /// Whether earlier plans count; otherwise all views in the current V_global have gain 1.
        uses_history: bool,
        /// Number of the draw of thread timing.
        order: u64,
        /// Whether it is drawn once for the run rather than for every plan.
        lasting: bool,
    },
}

impl ChoiceRule {
    /// Returns the paper's defaults, with this draw of thread timing.
    pub fn max_flow(order: u64) -> Self {
        Self::MaxFlow { gamma: 0.5, uses_history: true, order, lasting: false }
    }
}

/// The result of a scan.
pub struct StepResult {
    /// The view of the scan.
    pub view: usize,
    /// The log-odds of the existing voxels.
    pub log_odds: Vec<f32>,
    /// Occupied voxels of the box over object voxels, wherever they are: the program's coverage.
    pub coverage: f64,
    /// The entropy of the box as a share of that of an unknown box.
    pub entropy: f64,
    /// The plan after the scan.
    pub plan: Option<PlanFacts>,
}

/// Numbers of a plan.
pub struct PlanFacts {
    /// Number of distinct rays.
    pub n_rays: usize,
    /// Planning time.
    pub time: Duration,
}

impl ScannedObject {
    /// Puts the recorded object in front of the paper's camera.
    pub fn new(recording: RecordedRun) -> Outcome<Self> {
        let intrinsics = Intrinsics::d435i();
        let camera = VirtualCamera::new(&recording.surface, &intrinsics)?;
        Ok(Self { recording, camera, intrinsics })
    }

    /// Takes ten scans with these slips, the first from view 0.
    pub fn run(&self, slips: Slips, choice: ChoiceRule) -> Outcome<Vec<StepResult>> {
        let mut state = RunState::new(self, slips, choice)?;
        let (mut steps, mut view) = (Vec::new(), 0);
        loop {
            let mut step = state.scan(view)?;
            if steps.len() + 1 == N_SCANS {
                steps.push(step);
                return Ok(steps);
            }
            (view, step.plan) = state.choose()?;
            steps.push(step);
        }
    }
}

/// The rays and the flow of a first plan.
pub struct FirstPlan {
    /// Number of distinct rays.
    pub n_rays: usize,
    /// Mean number of rays per view.
    pub rays_per_view: f64,
    /// Number of views without a ray.
    pub n_views_without: usize,
    /// Number of voxels in the flow.
    pub n_voxels: usize,
    /// Number of edges between voxels and rays, each counted once for every view of the ray.
    pub n_edges: usize,
    /// The optimal quality Q_T.
    pub quality: f64,
}

impl ScannedObject {
    /// Plans on the recorded first map.
    pub fn survey(&self, slips: Slips) -> Outcome<FirstPlan> {
        let mut state = RunState::new(self, slips, ChoiceRule::Recorded)?;
        state.camera = look_from(self.recording.positions[0], self.recording.center, &state.camera)?;
        state.log_odds.clone_from(&self.recording.maps[0]);
        let knowledge = Knowledge::new(&state.log_odds, &self.recording, slips.unknown_by_bands)?;
        let (rays, qualities) = (state.cast(&knowledge)?, Qualities::new(&knowledge, slips)?);
        let best = optimal_views(&qualities, &rays, self.recording.block.n_voxels(), slips, |_| false);
        let numbers = || rays.of_view.iter().flatten();
        Ok(FirstPlan {
            n_rays: rays.voxels.len(),
            rays_per_view: numbers().count() as f64 / rays.of_view.len() as f64,
            n_views_without: rays.of_view.iter().filter(|rays| rays.is_empty()).count(),
            n_voxels: best.n_served(),
            n_edges: numbers()
                .map(|&ray| in_flow(&qualities, &rays.voxels[ray as usize], slips).count())
                .sum(),
            quality: best.total_quality(),
        })
    }
}

/// A run in progress.
struct RunState<'a> {
    scene: &'a ScannedObject,
    slips: Slips,
    choice: ChoiceRule,
    draw: Random,
    ties: Ties,
    map: Map,
    camera: Pose,
    visited: Vec<usize>,
    log_odds: Vec<f32>,
    rays: Option<PlanningRays>,
    plans: Vec<Vec<u32>>,
}

impl<'a> RunState<'a> {
    fn new(scene: &'a ScannedObject, slips: Slips, choice: ChoiceRule) -> Outcome<Self> {
        let draw = match choice {
            ChoiceRule::Random(draw) => Random::new(draw, 1),
            ChoiceRule::Recorded | ChoiceRule::MaxFlow { .. } => Random::new(0, 0),
        };
        let ties = match choice {
            ChoiceRule::MaxFlow { order, lasting: true, .. } => Ties::Lasting(order),
            ChoiceRule::MaxFlow { order, lasting: false, .. } => Ties::Anew(Random::new(order, 2)),
            ChoiceRule::Recorded | ChoiceRule::Random(_) => Ties::Lasting(0),
        };
        let map = Map::new(scene.recording.created)?;
        let (visited, log_odds, plans) = Default::default();
        let camera = Pose::IDENTITY;
        Ok(Self { scene, slips, choice, draw, ties, map, camera, visited, log_odds, rays: None, plans })
    }

    /// Takes a scan and inserts it into the map.
    fn scan(&mut self, view: usize) -> Outcome<StepResult> {
        let recording = &self.scene.recording;
        self.camera = look_from(recording.positions[view], recording.center, &self.camera)?;
        let image = self.scene.camera.scan(&self.camera, !self.slips.hits_only);
        self.map.insert(&image, self.camera.translation(), self.slips.hits_only)?;
        self.visited.push(view);
        self.log_odds = self.map.log_odds();
        let knowledge = Knowledge::new(&self.log_odds, recording, self.slips.unknown_by_bands)?;
        Ok(StepResult {
            view,
            log_odds: self.log_odds.clone(),
            coverage: knowledge.n_occupied() as f64 / recording.n_object_voxels as f64,
            entropy: knowledge.entropy_share(),
            plan: None,
        })
    }

    fn choose(&mut self) -> Outcome<(usize, Option<PlanFacts>)> {
        match self.choice {
            ChoiceRule::Recorded => Ok((RECORDED_VIEWS[self.visited.len()], None)),
            ChoiceRule::Random(_) => loop {
                let view = self.draw.index(self.scene.recording.positions.len());
                if !self.visited.contains(&view) {
                    return Ok((view, None));
                }
            },
            ChoiceRule::MaxFlow { gamma, uses_history, .. } => {
                self.plan(gamma, uses_history).map(|(view, facts)| (view, Some(facts)))
            }
        }
    }

    /// Eqs. (1) to (7).
    fn plan(&mut self, gamma: f64, uses_history: bool) -> Outcome<(usize, PlanFacts)> {
        let start = Instant::now();
        let knowledge = Knowledge::new(&self.log_odds, &self.scene.recording, self.slips.unknown_by_bands)?;
        let rays = match self.rays.take().filter(|_| self.slips.rays_cast_once) {
            Some(rays) => rays,
            None => self.cast(&knowledge)?,
        };
        let qualities = Qualities::new(&knowledge, self.slips)?;
        let local = qualities.local_gains(&rays);
        let n_voxels = self.scene.recording.block.n_voxels();
        let best =
            optimal_views(&qualities, &rays, n_voxels, self.slips, |view| self.visited.contains(&view));
        let views = self.ties.views(&best, n_voxels);
        let n_rays = rays.voxels.len();
        if !uses_history {
            self.plans.clear();
        }
        self.plans.push(views);
        let flow = match uses_history {
            true => flow_gains(&self.plans, local.len(), self.slips),
            false => {
                flow_gains(&self.plans, local.len(), Slips { history_by_view_number: false, ..self.slips })
            }
        };
        let total = |gains: &[f64]| gains.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let (all_local, all_flow) = (total(&local), total(&flow));
        let gain = |view: usize| (1.0 - gamma) * local[view] / all_local + gamma * flow[view] / all_flow;
        let open = (0..local.len()).filter(|view| !self.visited.contains(view));
        let view = open.max_by(|&a, &b| gain(a).total_cmp(&gain(b)).then(b.cmp(&a)));
        let view = view.ok_or("all views are visited, expected more than ten")?;
        self.rays = Some(rays);
        Ok((view, PlanFacts { n_rays, time: start.elapsed() }))
    }

    fn cast(&self, knowledge: &Knowledge) -> Outcome<PlanningRays> {
        let is_end =
            knowledge.ray_ends(&self.log_odds, self.slips.rays_stop_at_unknown, &self.scene.recording);
        let (recording, intrinsics) = (&self.scene.recording, &self.scene.intrinsics);
        RayCaster { recording, intrinsics, slips: self.slips, is_end: &is_end }.cast(&self.camera)
    }
}
