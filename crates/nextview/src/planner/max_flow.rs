use super::survey::Survey;
use super::utility::{self, Utility};
use super::{Choice, FlowSummary, Plan, Situation, ViewPlanner, flow_gain};
use crate::Error;
use crate::flow::fewest_sets;
use crate::gain::LocalGain;
use crate::visibility::{FreeSpace, RayCaster, WorthCaster};
use serde::{Deserialize, Serialize};

/// Parameters of [`MaxFlow`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaxFlowConfig {
    /// Weight of the flow gain against the local gain, 0..=1; the paper's gamma. Default 0.5; with 0 the planner
    /// is greedy on the local gain and solves no flow.
    pub gamma: f64,
    /// Whether earlier plans count in the flow gain, as eqs. (4) and (5) say; the default. Without, as in the paper's table IV
    /// ("no history"), it is 1 for the optimal views of the present plan and 0 for the others.
    pub uses_history: bool,
    /// Distance between neighbouring planning rays at the far side of the box, in voxels of the finest size, positive. Default 2, which
    /// plans as well as 1 / sqrt(2), where [no voxel is missed](crate::visibility::NO_VOXEL_MISSED), at an eighth of the time; the
    /// paper thins its rays to about 10.
    pub ray_spacing: f64,
    /// How far rays see through free space. Default: without loss; the paper's eq. (2) lets them fade.
    pub free_space: FreeSpace,
    /// Weight of the movement cost against the global gain, 0..=1; the paper's theta (section V.D). Default 0: moving is
    /// free.
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

/// The planner of the paper: local information gain combined with the views of a maximum flow (section III).
#[derive(Clone, Copy, Debug)]
pub struct MaxFlow {
    config: MaxFlowConfig,
}

impl MaxFlow {
    /// A planner with checked parameters.
    pub fn new(config: MaxFlowConfig) -> Result<Self, Error> {
        if !(0.0..=1.0).contains(&config.gamma) {
            return Err(Error::invalid("gamma", config.gamma, "a number in 0..=1"));
        }
        utility::check_ray_spacing(config.ray_spacing)?;
        utility::check_theta(config.theta)?;
        Ok(Self { config })
    }
}

impl ViewPlanner for MaxFlow {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let Survey { local, best } = self.survey(situation);
        let optimal_views = fewest_sets(best.candidates());
        let history = if self.config.uses_history { situation.history } else { &[] };
        let past = history.iter().map(Vec::as_slice);
        let flow = flow_gain(past.chain([optimal_views.as_slice()]), local.len()); // eqs. (4), (5)
        Plan {
            choice: self.choose(situation, &local, &flow), // eqs. (6), (7)
            flow: (self.config.gamma > 0.0).then(|| FlowSummary {
                n_voxels: best.n_served(),
                quality: best.total_quality(),
                n_views: optimal_views.len(),
            }),
            optimal_views,
            ..Plan::default()
        }
    }
}

impl MaxFlow {
    /// Eqs. (1) to (3).
    fn survey(&self, situation: &Situation<'_>) -> Survey {
        let spacing = situation.in_snapshot_voxels(self.config.ray_spacing);
        let caster =
            RayCaster::new(situation.snapshot, situation.intrinsics, spacing, self.config.free_space)
                .expect("the constructor checked the ray spacing");
        let gain = LocalGain::new(situation.snapshot);
        let caster = WorthCaster::new(caster, situation.snapshot, gain.weights());
        Survey::new(situation, &caster, self.config.gamma > 0.0)
    }

    /// The view of largest global gain, eqs. (6) and (7), less the cost of moving there, among those not visited. A global
    /// gain is a mean of shares and takes the place of a share in the utility.
    fn choose(&self, situation: &Situation<'_>, local: &[f64], flow: &[f64]) -> Option<Choice> {
        let (local_total, flow_total) = (local.iter().sum::<f64>(), flow.iter().sum::<f64>());
        let MaxFlowConfig { gamma, theta, .. } = self.config;
        let utility = Utility::new(situation, theta);
        let rate = |view: usize| {
            let local_share = utility::share(local[view], local_total);
            let flow_share = utility::share(flow[view], flow_total);
            let score = utility.of(view, (1.0 - gamma) * local_share + gamma * flow_share);
            Choice { view, score, local_share, flow_share, runner_up: None }
        };
        let open = situation.open_views().into_iter();
        utility::best(open.filter(|&view| local[view] > 0.0).map(rate))
    }
}
