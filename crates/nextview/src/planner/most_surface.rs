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
    /// Distance between neighbouring planning rays at the far side of the box, in voxels, positive. Default 1.
    ///
    /// The voxels are those of the snapshot or, if it has more than 72 along a side, larger ones. All views are looked at
    /// with rays three times as far apart first, and only the best 40 with these.
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
///
/// It tells an [`Outlook`] with each plan. What could be seen is what all views within reach show in the first look.
///
/// ```
/// use nextview::planner::{MostSurface, MostSurfaceConfig};
///
/// let planner = MostSurface::new(MostSurfaceConfig { theta: 0.3, ..MostSurfaceConfig::default() });
/// assert!(planner.is_ok());
/// ```
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
        let first = scene.survey(&situation.open_views(), FIRST_LOOK * self.config.ray_spacing);
        let rating = Rating {
            utility: Utility::new(situation, self.config.theta),
            total: first.gains.iter().map(|(_, gain)| gain).sum(),
        };
        let second = scene.survey(&rating.shortlist(&first.gains), self.config.ray_spacing);
        let best = rating.best(&second.gains);
        let outlook = Outlook {
            n_seen: snapshot.count(Occupancy::Occupied),
            n_expected: best.map_or(0.0, |(_, gain)| gain),
            n_unseen: first.shown.iter().map(|&p| p as f64).sum(),
        };
        Plan { choice: best.map(|(choice, _)| choice), outlook: Some(outlook), ..Plan::default() }
    }
}

/// What makes a view better than another.
struct Rating {
    utility: Utility,
    /// What all views show in the first look, added up.
    total: f64,
}

impl Rating {
    fn rate(&self, view: usize, gain: f64) -> Choice {
        let local_share = utility::share(gain, self.total);
        let score = self.utility.of(view, local_share);
        Choice { view, score, local_share, flow_share: 0.0, runner_up: None }
    }

    /// The views that are worth a second look.
    fn shortlist(&self, gains: &[(usize, f64)]) -> Vec<usize> {
        let mut rated: Vec<Choice> = gains.iter().map(|&(view, gain)| self.rate(view, gain)).collect();
        rated.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.view.cmp(&b.view)));
        rated.truncate(N_SHORTLISTED);
        rated.iter().map(|choice| choice.view).collect()
    }

    /// The best of the views that show anything, and its gain.
    fn best(&self, gains: &[(usize, f64)]) -> Option<(Choice, f64)> {
        let worthwhile = gains.iter().filter(|(_, gain)| *gain >= LEAST_GAIN);
        let choice = utility::best(worthwhile.map(|&(view, gain)| self.rate(view, gain)))?;
        let (_, gain) = gains.iter().find(|(view, _)| *view == choice.view)?;
        Some((choice, *gain))
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
        let mut all = parts.map(|(survey, _)| survey).reduce(nothing, Survey::join);
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
