use super::utility::{self, Utility};
use super::{Choice, Outlook, Plan, Situation, ViewPlanner, second_view};
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
    /// How many planning rays side by side cover the longest side of the box, at its far side; 1..=1000. Default 32.
    ///
    /// More than 1000 views are looked at with an eighth as many first, the best 1000 of them with a quarter, the best 250 of
    /// these with half as many, and only the best 40 with all of them. So there are as many rays in fine voxels as in coarse
    /// ones.
    pub rays_across: f64,
    /// Weight of the movement cost against the gain, 0..=1; the paper's theta (section V.D). Default 0: moving is free.
    pub theta: f64,
}

impl Default for MostSurfaceConfig {
    fn default() -> Self {
        Self { rays_across: 32.0, theta: 0.0 }
    }
}

/// One look after the other: at how many of the best views so far, and by what factor rays are farther apart. Looks at more
/// views than there are, but the closest of them, are left out: with few views and few rays, too little would be seen at all.
const LOOKS: [(usize, f64); 4] = [(usize::MAX, 8.0), (1000, 4.0), (250, 2.0), (40, 1.0)];

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
        check_rays_across(config.rays_across)?;
        Ok(Self { config, prior })
    }
}

impl ViewPlanner for MostSurface {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let snapshot = coarse_enough(situation.snapshot);
        let estimate = self.prior.estimate(&snapshot);
        let scene = Scene { situation, snapshot: &snapshot, estimate: &estimate };
        let open = situation.open_views();
        let ray_spacing = snapshot.block().dims().max_element() as f64 / self.config.rays_across;
        let first_look = LOOKS.iter().rposition(|(n_views, _)| *n_views >= open.len()).unwrap_or(0);
        let first = scene.survey(&open, LOOKS[first_look].1 * ray_spacing);
        let mut rating = Rating::new(&scene, self.config.theta, first.gains);
        for &(n_views, factor) in &LOOKS[first_look + 1..] {
            rating.shortlist(n_views);
            let closer = scene.survey(&rating.views(), factor * ray_spacing);
            rating.look_closer(closer.gains);
        }
        let best = rating.best();
        let outlook = Outlook {
            n_seen: snapshot.count(Occupancy::Occupied),
            n_expected: best.map_or(0.0, |(_, gain)| gain),
            n_unseen: first.shown.iter().map(|&p| p as f64).sum(),
        };
        Plan { choice: best.map(|(choice, _)| choice), outlook: Some(outlook), ..Plan::default() }
    }
}

fn check_rays_across(rays_across: f64) -> Result<(), Error> {
    if (1.0..=1000.0).contains(&rays_across) {
        return Ok(());
    }
    Err(Error::invalid("rays_across", rays_across, "a number in 1..=1000"))
}

/// Views, and what makes one better than another.
struct Rating {
    utility: Utility,
    /// By view, what is added to its gain, in shares of the largest.
    advantages: Vec<f64>,
    /// Views with what they are expected to show.
    gains: Vec<(usize, f64)>,
    /// What all views are worth, added up.
    total: f64,
}

impl Rating {
    fn new(scene: &Scene<'_>, theta: f64, gains: Vec<(usize, f64)>) -> Self {
        let utility = Utility::new(scene.situation, theta);
        let advantages = second_view::advantages(scene.situation, scene.snapshot);
        let rating = Self { utility, advantages, gains, total: 0.0 };
        Self { total: rating.worth(), ..rating }
    }

    /// What the views are worth, added up.
    fn worth(&self) -> f64 {
        self.worths().map(|(_, _, worth)| worth).sum()
    }

    /// Views with their gains and what these are worth.
    fn worths(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let largest = self.gains.iter().fold(0.0, |largest: f64, (_, gain)| largest.max(*gain));
        self.gains.iter().map(move |&(view, gain)| (view, gain, gain + self.advantages[view] * largest))
    }

    fn ranked(&self) -> impl Iterator<Item = (Choice, f64)> {
        self.worths().map(|(view, gain, worth)| {
            let local_share = utility::share(worth, self.total);
            let score = self.utility.of(view, local_share);
            (Choice { view, score, local_share, flow_share: 0.0, runner_up: None }, gain)
        })
    }

    /// Leaves the best so many.
    fn shortlist(&mut self, n_views: usize) {
        let mut ranked: Vec<(Choice, f64)> = self.ranked().collect();
        ranked.sort_by(|(a, _), (b, _)| b.score.total_cmp(&a.score).then(a.view.cmp(&b.view)));
        ranked.truncate(n_views);
        self.gains = ranked.into_iter().map(|(choice, gain)| (choice.view, gain)).collect();
        self.gains.sort_unstable_by_key(|(view, _)| *view);
    }

    fn views(&self) -> Vec<usize> {
        self.gains.iter().map(|(view, _)| *view).collect()
    }

    /// The gains of the same views with denser rays, which meet more voxels: all views would be worth as much more.
    fn look_closer(&mut self, gains: Vec<(usize, f64)>) {
        let before = self.worth();
        self.gains = gains;
        if before > 0.0 {
            self.total *= self.worth() / before;
        }
    }

    /// The best of the views that show anything, and its gain.
    fn best(&self) -> Option<(Choice, f64)> {
        let worthwhile = || self.ranked().filter(|(_, gain)| *gain >= LEAST_GAIN);
        let choice = utility::best(worthwhile().map(|(choice, _)| choice))?;
        worthwhile().find(|(other, _)| other.view == choice.view).map(|(_, gain)| (choice, gain))
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
        let gain = gain.expect("the constructor checked the number of rays");
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
