use super::utility::{self, Utility};
use super::{Choice, Outlook, Plan, Situation, ViewPlanner};
use crate::Error;
use crate::gain::{ExpectedSurface, Eye};
use crate::map::{Occupancy, Snapshot};
use crate::prior::{SurfaceEstimate, SurfacePrior, coarse_enough};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters of [`MostSurface`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MostSurfaceConfig {
    /// Distance between neighbouring planning rays at the far side of the box, in voxels, positive. Default 1. The voxels are those of the
    /// snapshot or, if it has more than 72 along a side, larger ones. All views are looked at with rays three times as far apart first, and only the best
    /// 40 with these.
    pub ray_spacing: f64,
    /// Weight of the movement cost against the gain, 0..=1; the paper's theta (section V.D). Default 0: moving is free.
    pub theta: f64,
}

impl Default for MostSurfaceConfig {
    fn default() -> Self {
        Self { ray_spacing: 1.0, theta: 0.0 }
    }
}

/// Rays of the first look are farther apart by this factor.
const FIRST_LOOK: f64 = 3.0;

/// Views that get a second look.
const N_SHORTLISTED: usize = 40;

/// A view is expected to show something if it is this many voxels.
const LEAST_GAIN: f64 = 0.5;

/// Takes the view that is expected to show most surface that was not seen before: the gain [`ExpectedSurface`].
#[derive(Clone, Debug)]
pub struct MostSurface {
    config: MostSurfaceConfig,
    prior: SurfacePrior,
}

impl MostSurface {
    /// A planner with checked parameters and the library's prior.
    pub fn new(config: MostSurfaceConfig) -> Result<Self, Error> {
        Self::with_prior(config, SurfacePrior::default())
    }

    /// A planner with checked parameters and a prior of your own.
    pub fn with_prior(config: MostSurfaceConfig, prior: SurfacePrior) -> Result<Self, Error> {
        utility::check_theta(config.theta)?;
        utility::check_ray_spacing(config.ray_spacing)?;
        Ok(Self { config, prior })
    }
}

impl ViewPlanner for MostSurface {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let snapshot = coarse_enough(situation.snapshot);
        let estimate = self.prior.estimate(&snapshot);
        let scene = Scene { situation, snapshot: &snapshot, estimate: &estimate };
        let utility = Utility::new(situation, self.config.theta);
        let first = scene.survey(&situation.open_views(), FIRST_LOOK * self.config.ray_spacing);
        let total: f64 = first.gains.iter().map(|(_, gain)| gain).sum();
        let rate = |&(view, gain): &(usize, f64)| {
            let local_share = utility::share(gain, total);
            let score = utility.of(view, local_share);
            (Choice { view, score, local_share, flow_share: 0.0, runner_up: None }, gain)
        };
        let mut rated: Vec<(Choice, f64)> = first.gains.iter().map(rate).collect();
        rated.sort_by(|(a, _), (b, _)| b.score.total_cmp(&a.score).then(a.view.cmp(&b.view)));
        rated.truncate(N_SHORTLISTED);
        let shortlist: Vec<usize> = rated.iter().map(|(choice, _)| choice.view).collect();
        let second = scene.survey(&shortlist, self.config.ray_spacing);
        let rated: Vec<(Choice, f64)> =
            second.gains.iter().map(rate).filter(|(_, gain)| *gain >= LEAST_GAIN).collect();
        let choice = utility::best(rated.iter().map(|(choice, _)| *choice));
        let gain = rated.iter().find(|(rated, _)| choice.is_some_and(|choice| choice.view == rated.view));
        let outlook = Outlook {
            n_seen: snapshot.count(Occupancy::Occupied),
            n_expected: gain.map_or(0.0, |(_, gain)| *gain),
            n_unseen: first.shown.iter().map(|&p| p as f64).sum(),
        };
        Plan { choice, outlook: Some(outlook), ..Plan::default() }
    }
}

/// Where views are compared.
struct Scene<'a> {
    situation: &'a Situation<'a>,
    snapshot: &'a Snapshot,
    estimate: &'a SurfaceEstimate,
}

/// What some views show.
struct Survey {
    /// Views with what they are expected to show, by increasing number.
    gains: Vec<(usize, f64)>,
    /// By voxel of the estimate, the probability that the view sees it which sees it best.
    shown: Vec<f32>,
}

impl Scene<'_> {
    /// Looks from these views with rays so many voxels apart.
    fn survey(&self, views: &[usize], ray_spacing: f64) -> Survey {
        let gain = ExpectedSurface::new(self.snapshot, self.situation.intrinsics, self.estimate, ray_spacing);
        let gain = gain.expect("the constructor checked the ray spacing");
        let nothing = || Survey { gains: Vec::new(), shown: vec![0.0; self.estimate.len()] };
        let parts = views.par_iter().fold(
            || (nothing(), gain.eye()),
            |(mut survey, mut eye), &view| {
                survey.add(view, self.estimate, &mut eye, self.situation);
                (survey, eye)
            },
        );
        let parts = parts.map(|(survey, _)| survey);
        let mut all = parts.reduce(nothing, Survey::join);
        all.gains.sort_unstable_by_key(|(view, _)| *view);
        all
    }
}

impl Survey {
    fn add(&mut self, view: usize, estimate: &SurfaceEstimate, eye: &mut Eye<'_>, situation: &Situation<'_>) {
        let mut gain = 0.0;
        eye.look(&situation.views.pose(view), |item, sighting| {
            let p = estimate.shows(item, sighting);
            self.shown[item] = self.shown[item].max(p);
            gain += p as f64;
        });
        self.gains.push((view, gain));
    }

    fn join(mut self, other: Self) -> Self {
        self.gains.extend(other.gains);
        self.shown.iter_mut().zip(other.shown).for_each(|(a, b)| *a = a.max(b));
        self
    }
}
