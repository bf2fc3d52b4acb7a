mod flow_gain;
mod survey;

pub use flow_gain::flow_gain;

use super::utility::{self, Utility};
use super::{Choice, Explanation, Plan, Situation, ViewPlanner};
use crate::checked::{check_range, checked_when_read};
use crate::flow::{BestSets, fewest_sets};
use crate::gain::LocalGain;
use crate::visibility::{FreeSpace, RayCaster, ValueCaster};
use crate::{Cancelled, Error};
use serde::{Deserialize, Serialize};
use survey::FlowSurvey;

/// Parameters of [`MaxFlow`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct MaxFlowConfig {
    /// Weight of the flow gain against the local gain, 0..=1; the paper's gamma. Default 0.5; with 0 the
    /// planner is greedy on the local gain and solves no flow.
    pub gamma: f64,
    /// Whether earlier plans count in the flow gain, as in eqs. (4) and (5); the default. If not, as in the
    /// paper's table IV ("no history"), the flow gain is 1 for the optimal views of the present plan and 0
    /// for the others.
    pub uses_history: bool,
    /// Distance between neighbouring planning rays at the far side of the box, in voxels of the finest size,
    /// at least 0.1. Default 2, which plans as well as 1 / sqrt(2), where [no voxel is
    /// missed](crate::visibility::NO_VOXEL_MISSED), in an eighth of the time; the paper thins its rays to
    /// about 10.
    pub ray_spacing: f64,
    /// How far rays see through free space. Default: without loss; the paper's eq. (2) lets them fade.
    pub free_space: FreeSpace,
    /// Weight of the movement cost against the global gain, 0..=1; the paper's theta (section V.D). Default
    /// 0: moving has no cost.
    pub theta: f64,
}

impl Default for MaxFlowConfig {
    fn default() -> Self {
        Self {
            gamma: 0.5,
            uses_history: true,
            ray_spacing: 2.0,
            free_space: FreeSpace::default(),
            theta: 0.0,
        }
    }
}

checked_when_read!(MaxFlowConfig);

impl MaxFlowConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        check_range("gamma", self.gamma, 0.0..=1.0, "a number in 0..=1")?;
        utility::check_ray_spacing(self.ray_spacing)?;
        utility::check_theta(self.theta)
    }
}

/// The paper's planner: local information gain combined with the views of a maximum flow (section III).
///
/// It remembers the optimal views of its plans, so each scan needs its own planner.
#[derive(Clone, Debug)]
pub struct MaxFlow {
    config: MaxFlowConfig,
    /// V_global of every plan with a choice so far.
    history: Vec<Vec<u32>>,
}

impl MaxFlow {
    /// Creates a planner. Fails if a parameter is out of range.
    pub fn new(config: MaxFlowConfig) -> Result<Self, Error> {
        config.check()?;
        Ok(Self { config, history: Vec::new() })
    }
}

impl ViewPlanner for MaxFlow {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let FlowSurvey { local, best } = self.survey(situation)?;
        let optimal_views = fewest_sets(best.candidates(), situation.cancel())?;
        let history = if self.config.uses_history { self.history.as_slice() } else { &[] };
        let past = history.iter().map(Vec::as_slice);
        let flow = flow_gain(past.chain([optimal_views.as_slice()]), local.len()); // eqs. (4), (5)
        let mut choice = self.choose(situation, &local, &flow); // eqs. (6), (7)
        if let Some(choice) = &mut choice {
            choice.explanation =
                Some(self.explanation(choice.view, &local, &flow, &best, optimal_views.len()));
            self.history.push(optimal_views);
        }
        Ok(Plan { choice, ..Plan::default() })
    }
}

impl MaxFlow {
    /// Returns the optimal views (the paper's V_global) of every plan with a choice so far, oldest first: the
    /// views that together serve every voxel best, in increasing order.
    pub fn history(&self) -> &[Vec<u32>] {
        &self.history
    }

    /// Eqs. (1) to (3).
    fn survey(&self, situation: &Situation<'_>) -> Result<FlowSurvey, Cancelled> {
        let (snapshot, cancel) = (situation.snapshot(), situation.cancel());
        let spacing = situation.in_snapshot_voxels(self.config.ray_spacing);
        let gain = LocalGain::new(snapshot, cancel)?;
        let caster = RayCaster::new(snapshot, situation.intrinsics(), spacing, self.config.free_space)
            .expect("the constructor checked the ray spacing")
            .within(situation.depth_range());
        cancel.check()?;
        let caster = ValueCaster::new(caster, snapshot, gain.weights());
        FlowSurvey::new(situation, &caster, self.config.gamma > 0.0)
    }

    /// The view of largest global gain, eqs. (6) and (7), less the cost of moving there, among those not
    /// visited. A global gain is a mean of shares and takes the place of a share in the utility.
    fn choose(&self, situation: &Situation<'_>, local: &[f64], flow: &[f64]) -> Option<Choice> {
        let (local_total, flow_total) = (local.iter().sum::<f64>(), flow.iter().sum::<f64>());
        let MaxFlowConfig { gamma, theta, .. } = self.config;
        let utility = Utility::new(situation, theta);
        let rate = |view: usize| {
            let local_share = utility::share(local[view], local_total);
            let flow_share = utility::share(flow[view], flow_total);
            Choice::new(view, utility.of(view, (1.0 - gamma) * local_share + gamma * flow_share))
        };
        let open = situation.open_views().into_iter();
        utility::best(open.filter(|&view| local[view] > 0.0).map(rate))
    }

    /// The shares of a view in all local gain and all flow gain (eq. 6), and the flow behind the latter (eq.
    /// 3): the number of voxels it serves, their quality, and the number of views that carry it.
    fn explanation(
        &self,
        view: usize,
        local: &[f64],
        flow: &[f64],
        best: &BestSets,
        n_views: usize,
    ) -> Explanation {
        let local_share = utility::share(local[view], local.iter().sum());
        if self.config.gamma == 0.0 {
            return [("local_share", local_share)].into();
        }
        Explanation::from([
            ("local_share", local_share),
            ("flow_share", utility::share(flow[view], flow.iter().sum())),
            ("flow_voxels", best.n_served() as f64),
            ("flow_quality_nats", best.total_quality()),
            ("flow_views", n_views as f64),
        ])
    }
}
