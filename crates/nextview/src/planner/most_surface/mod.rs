mod doubt;
mod second_look;
mod second_view;

use super::utility::{self, Utility};
use super::{Choice, Outlook, Plan, Situation, ViewPlanner};
use crate::checked::{check_range, checked_when_read};
use crate::gain::{ExpectedSurface, ViewEvaluator};
use crate::map::{Occupancy, Snapshot};
use crate::prior::{SurfaceEstimate, SurfacePrior, coarse_enough};
use crate::visibility::MeasuredParts;
use crate::{Cancelled, Error};
use doubt::Doubt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters of [`MostSurface`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct MostSurfaceConfig {
    /// Number of planning rays side by side across the longest side of the box, at its far side; 1..=1000.
    /// Default 32.
    ///
    /// More than 1000 views are first evaluated with an eighth as many rays, the best 1000 of them with a
    /// quarter, the best 150 of these with half as many, and only the best 24 with all rays. The number of
    /// rays is the same in fine voxels as in coarse ones.
    pub rays_across: f64,
    /// Weight of the movement cost against the gain, 0..=1; the paper's theta (section V.D). Default 0:
    /// moving is free.
    pub theta: f64,
}

impl Default for MostSurfaceConfig {
    fn default() -> Self {
        Self { rays_across: 32.0, theta: 0.0 }
    }
}

checked_when_read!(MostSurfaceConfig);

impl MostSurfaceConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        utility::check_theta(self.theta)?;
        check_range("rays_across", self.rays_across, 1.0..=1000.0, "a number in 1..=1000")
    }
}

/// Passes, one after the other: the number of best views so far, and the factor by which rays are farther
/// apart. Passes over more views than there are, except for the last such pass, are left out: few views with
/// few rays show too little.
const PASSES: [(usize, f64); 4] = [(usize::MAX, 8.0), (1000, 4.0), (150, 2.0), (24, 1.0)];

/// A view is expected to show something if its gain is at least this many voxels.
const LEAST_GAIN: f64 = 0.5;

/// Takes the view that is expected to show most surface that was not seen before: the gain
/// [`ExpectedSurface`].
///
/// With a [goal](Situation::goal), the gain of second looks at surface that was not measured well enough is
/// added with a tenth of its weight: new surface comes first.
///
/// A view that shows hardly anything of what was expected lowers the expectations of the same voxels.
///
/// Each plan has an [`Outlook`]. The surface that can be seen is the surface that all views within reach show
/// in the first pass.
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
    doubt: Doubt,
    /// Of the last plan, so that no frame is read twice.
    measured: Option<MeasuredParts>,
}

impl MostSurface {
    /// A planner with checked parameters and the library's prior.
    pub fn new(config: MostSurfaceConfig) -> Result<Self, Error> {
        Self::with_prior(config, SurfacePrior::default())
    }

    /// A planner with checked parameters and a prior of your own.
    pub fn with_prior(config: MostSurfaceConfig, prior: SurfacePrior) -> Result<Self, Error> {
        config.check()?;
        Ok(Self { config, prior, doubt: Doubt::default(), measured: None })
    }
}

impl ViewPlanner for MostSurface {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let snapshot = coarse_enough(situation.snapshot(), situation.cancel())?;
        let mut estimate = self.prior.estimate(&snapshot, situation.cancel())?;
        let mut doubt = self.doubt.learned(situation, &snapshot);
        doubt.lower(&mut estimate, &snapshot);
        let (frames, cancel) = (situation.frames(), situation.cancel());
        let measured = match self.measured.take() {
            Some(before) => before.after(frames, &snapshot, cancel)?,
            None => MeasuredParts::new(frames, &snapshot, cancel)?,
        };
        let measured: &MeasuredParts = self.measured.insert(measured);
        let scene = Scene { situation, snapshot: &snapshot, measured, estimate: &estimate };
        let open = situation.open_views();
        let ray_spacing = snapshot.block().dims().max_element() as f64 / self.config.rays_across;
        let first_pass = PASSES.iter().rposition(|(n_views, _)| *n_views >= open.len()).unwrap_or(0);
        let first = scene.survey(&open, PASSES[first_pass].1 * ray_spacing)?;
        let mut rating = Rating::new(&scene, self.config.theta, first.gains)?;
        for &(n_views, factor) in &PASSES[first_pass + 1..] {
            rating.shortlist(n_views);
            let closer = scene.survey(&rating.views(), factor * ray_spacing)?;
            rating.refine(closer.gains);
        }
        let best = rating.best();
        let outlook = Outlook {
            n_seen: snapshot.count(Occupancy::Occupied),
            n_expected: best.as_ref().map_or(0.0, |(_, gain)| *gain),
            n_unseen: first.shown.iter().map(|&p| p as f64).sum(),
        };
        if let Some((choice, gain)) = &best {
            let shown = scene.survey(&[choice.view], ray_spacing)?.shown;
            let shown = shown.into_iter().enumerate();
            doubt.expect((choice.view, *gain), shown, &estimate, situation, &snapshot);
        }
        self.doubt = doubt;
        Ok(Plan { choice: best.map(|(choice, _)| choice), outlook: Some(outlook), ..Plan::default() })
    }
}

/// Views with the quantities that rank them.
struct Rating {
    utility: Utility,
    /// By view, the bonus added to its gain, in shares of the largest.
    advantages: Vec<f64>,
    /// By view, the value of a second look at what it shows, in voxels; empty without a goal.
    second_looks: Vec<f64>,
    /// Views with their expected gains.
    gains: Vec<(usize, f64)>,
    /// Sum of the values of all views.
    total: f64,
}

impl Rating {
    fn new(scene: &Scene<'_>, theta: f64, gains: Vec<(usize, f64)>) -> Result<Self, Cancelled> {
        let second_looks = second_look::values(scene.situation, scene.snapshot)?;
        let utility = Utility::new(scene.situation, theta);
        let advantages = second_view::advantages(scene.situation, scene.snapshot);
        let rating = Self { utility, advantages, second_looks, gains, total: 0.0 };
        Ok(Self { total: rating.value(), ..rating })
    }

    /// Sum of the values of the views.
    fn value(&self) -> f64 {
        self.values().map(|(_, _, value)| value).sum()
    }

    fn second_look(&self, view: usize) -> f64 {
        self.second_looks.get(view).copied().unwrap_or_default()
    }

    /// Views with their gains and values.
    fn values(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let largest = self.gains.iter().fold(0.0, |largest: f64, (_, gain)| largest.max(*gain));
        self.gains.iter().map(move |&(view, gain)| {
            (view, gain, gain + self.second_look(view) + self.advantages[view] * largest)
        })
    }

    fn ranked(&self) -> impl Iterator<Item = (Choice, f64)> {
        self.values().map(|(view, gain, value)| {
            let local_share = utility::share(value, self.total);
            (Choice::new(view, self.utility.of(view, local_share)), gain)
        })
    }

    /// Keeps the best `n_views` views.
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

    /// The gains of the same views with denser rays, which meet more voxels: all values grow by the same
    /// factor.
    fn refine(&mut self, gains: Vec<(usize, f64)>) {
        let before = self.value();
        self.gains = gains;
        if before > 0.0 {
            self.total *= self.value() / before;
        }
    }

    /// The best of the views that show anything, and its gain.
    fn best(&self) -> Option<(Choice, f64)> {
        let is_worthwhile =
            |(choice, gain): &(Choice, f64)| gain + self.second_look(choice.view) >= LEAST_GAIN;
        let worthwhile = self.ranked().filter(is_worthwhile);
        let choice = utility::best(worthwhile.map(|(choice, _)| choice))?;
        let (_, gain, value) = self.values().find(|(view, ..)| *view == choice.view)?;
        let explanation = [("local_share", utility::share(value, self.total))].into();
        Some((Choice { explanation: Some(explanation), ..choice }, gain))
    }
}

/// The setting in which views are compared.
struct Scene<'a> {
    situation: &'a Situation<'a>,
    snapshot: &'a Snapshot,
    measured: &'a MeasuredParts,
    estimate: &'a SurfaceEstimate,
}

/// Survey of some views.
struct Survey {
    /// Views with their expected gains, by increasing number.
    gains: Vec<(usize, f64)>,
    /// By voxel of the estimate, the probability of the view that sees it best.
    shown: Vec<f32>,
}

impl Scene<'_> {
    /// Surveys these views with rays `ray_spacing` voxels apart.
    fn survey(&self, views: &[usize], ray_spacing: f64) -> Result<Survey, Cancelled> {
        let (intrinsics, depth_range) = (self.situation.intrinsics(), self.situation.depth_range());
        let (snapshot, measured) = (self.snapshot, self.measured);
        let gain =
            ExpectedSurface::new(snapshot, intrinsics, depth_range, measured, self.estimate, ray_spacing);
        let gain = gain.expect("the constructor checked the number of rays");
        let nothing = || Survey { gains: Vec::new(), shown: vec![0.0; self.estimate.len()] };
        let parts = views.par_iter().try_fold(
            || (nothing(), gain.evaluator()),
            |(mut survey, mut evaluator), &view| {
                self.situation.cancel().check()?;
                survey.add(view, self.estimate, &mut evaluator, self.situation);
                Ok((survey, evaluator))
            },
        );
        let surveys = parts.map(|part| part.map(|(survey, _)| survey));
        let mut all = surveys.try_reduce(nothing, |a, b| Ok(a.join(b)))?;
        all.gains.sort_unstable_by_key(|(view, _)| *view);
        Ok(all)
    }
}

impl Survey {
    fn add(
        &mut self,
        view: usize,
        estimate: &SurfaceEstimate,
        evaluator: &mut ViewEvaluator<'_>,
        situation: &Situation<'_>,
    ) {
        let mut gain = 0.0;
        evaluator.survey(&situation.views().pose(view), |item, class| {
            let p = estimate.shows(item, class);
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
