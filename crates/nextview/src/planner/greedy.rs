use super::utility::{self, Utility};
use super::{Choice, Plan, Situation, ViewPlanner};
use crate::checked::checked_when_read;
use crate::gain::InformationGain;
use crate::visibility::{RayCaster, Sight};
use crate::{Cancelled, Error};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;

/// Parameters of [`Greedy`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct GreedyConfig {
    /// Distance between neighbouring planning rays at the far side of the box, in voxels of the finest size,
    /// at least 0.1. Default 2, as for [`MaxFlow`](super::MaxFlow).
    pub ray_spacing: f64,
    /// Weight of the movement cost against the gain, 0..=1; the paper's theta (section V.D). Default 0:
    /// moving has no cost.
    pub theta: f64,
}

impl Default for GreedyConfig {
    fn default() -> Self {
        Self { ray_spacing: 2.0, theta: 0.0 }
    }
}

checked_when_read!(GreedyConfig);

impl GreedyConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        utility::check_theta(self.theta)?;
        utility::check_ray_spacing(self.ray_spacing)
    }

    /// The ray caster for checked parameters.
    pub(super) fn caster<'a>(&self, situation: &Situation<'a>, sight: Sight) -> RayCaster<'a> {
        let spacing = situation.in_snapshot_voxels(self.ray_spacing);
        RayCaster::new(situation.snapshot(), situation.intrinsics(), spacing, sight)
            .expect("the constructor checked the ray spacing")
            .within(situation.depth_range())
    }

    /// Plans the open view of largest utility, for one gain per open view.
    pub(super) fn plan(&self, situation: &Situation<'_>, open: &[usize], gains: &[f64]) -> Plan {
        let total: f64 = gains.iter().sum();
        let utility = Utility::new(situation, self.theta);
        let rate = |(&view, &gain): (&usize, &f64)| {
            let local_share = utility::share(gain, total);
            (Choice::new(view, utility.of(view, local_share)), local_share)
        };
        let rated = || open.iter().zip(gains).filter(|(_, gain)| **gain > 0.0).map(rate);
        let choice = utility::best(rated().map(|(choice, _)| choice)).map(|choice| {
            let local_share = rated().find(|(other, _)| other.view == choice.view).map(|(_, share)| share);
            let explanation = local_share.map(|share| [("local_share", share)].into());
            Choice { explanation, ..choice }
        });
        Plan { choice, ..Plan::default() }
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
    /// Creates a planner. Fails if a parameter is out of range.
    pub fn new(config: GreedyConfig) -> Result<Self, Error> {
        config.check()?;
        Ok(Self { config, gain: PhantomData })
    }

    /// Returns the gain of each of these views, in the unit of the gain.
    pub fn gains(&self, situation: &Situation<'_>, views: &[usize]) -> Result<Vec<f64>, Cancelled> {
        let gain = G::new(situation.snapshot(), situation.frames(), situation.cancel())?;
        let caster = self.config.caster(situation, G::SIGHT);
        let gain_of = |&view: &usize| {
            let mut tally = G::Tally::default();
            caster.try_cast(&situation.views().pose(view), |ray| {
                gain.add(&ray, &mut tally);
                situation.cancel().check()
            })?;
            Ok(G::total(&tally))
        };
        views.par_iter().map(gain_of).collect()
    }
}

impl<G: InformationGain> ViewPlanner for Greedy<G> {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let open = situation.open_views();
        let gains = self.gains(situation, &open)?;
        Ok(self.config.plan(situation, &open, &gains))
    }
}
