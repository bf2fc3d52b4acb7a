use super::utility::{self, Utility};
use super::{Choice, Plan, Situation, ViewPlanner};
use crate::Error;
use crate::gain::InformationGain;
use crate::visibility::RayCaster;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;

/// Parameters of [`Greedy`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GreedyConfig {
    /// Distance between neighbouring planning rays at the far side of the box, in voxels of the finest size, positive.
    /// Default 2, as for [`MaxFlow`](super::MaxFlow).
    pub ray_spacing: f64,
    /// Weight of the movement cost against the gain, 0..=1; the paper's theta (section V.D). Default 0: moving is free.
    pub theta: f64,
}

impl Default for GreedyConfig {
    fn default() -> Self {
        Self { ray_spacing: 2.0, theta: 0.0 }
    }
}

/// Takes the view of largest utility: its share of all information gain, less the cost of moving there.
///
/// ```
/// use nextview::gain::RearSideEntropy;
/// use nextview::planner::{Greedy, GreedyConfig};
///
/// let planner = Greedy::<RearSideEntropy>::new(GreedyConfig { theta: 0.3, ..GreedyConfig::default() });
/// assert!(planner.is_ok());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Greedy<G> {
    config: GreedyConfig,
    gain: PhantomData<fn() -> G>,
}

impl<G: InformationGain> Greedy<G> {
    /// A planner with checked parameters.
    pub fn new(config: GreedyConfig) -> Result<Self, Error> {
        utility::check_theta(config.theta)?;
        utility::check_ray_spacing(config.ray_spacing)?;
        Ok(Self { config, gain: PhantomData })
    }

    /// The gain of each of the views.
    fn gains(&self, situation: &Situation<'_>, views: &[usize]) -> Vec<f64> {
        let gain = G::new(situation.snapshot, situation.frames);
        let spacing = situation.in_snapshot_voxels(self.config.ray_spacing);
        let caster = RayCaster::new(situation.snapshot, situation.intrinsics, spacing, G::SIGHT)
            .expect("the constructor checked the ray spacing");
        let look = |&view: &usize| {
            let mut tally = G::Tally::default();
            caster.cast(&situation.views.pose(view), |ray| gain.add(&ray, &mut tally));
            G::total(&tally)
        };
        views.par_iter().map(look).collect()
    }
}

impl<G: InformationGain> ViewPlanner for Greedy<G> {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let open = situation.open_views();
        let gains = self.gains(situation, &open);
        let total: f64 = gains.iter().sum();
        let utility = Utility::new(situation, self.config.theta);
        let rate = |(&view, &gain): (&usize, &f64)| {
            let local_share = utility::share(gain, total);
            let score = utility.of(view, local_share);
            Choice { view, score, local_share, flow_share: 0.0, runner_up: None }
        };
        let choices = open.iter().zip(&gains).filter(|(_, gain)| **gain > 0.0).map(rate);
        Plan { choice: utility::best(choices), ..Plan::default() }
    }
}
