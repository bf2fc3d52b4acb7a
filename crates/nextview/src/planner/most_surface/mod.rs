mod doubt;
mod forecast;
mod second_look;
mod second_view;
mod setting;

use super::utility::{self, Utility};
use super::{Choice, Outlook, Plan, Situation, ViewPlanner};
use crate::checked::{check_range, checked_when_read};
use crate::map::Occupancy;
use crate::prior::{SurfacePrior, coarse_enough};
use crate::visibility::MeasuredParts;
use crate::{Cancelled, Error};
use doubt::Doubt;
use serde::{Deserialize, Serialize};
use setting::Setting;

/// Parameters of [`MostSurface`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct MostSurfaceConfig {
    /// Number of planning rays across the longest side of the box, at its far side; 1..=1000. Default 32.
    ///
    /// More than 1000 views are first evaluated with an eighth of the rays, the best 1000 of them with a
    /// quarter, the best 150 of these with half, and only the best 24 with all rays. The number of rays does
    /// not depend on the voxel size.
    pub rays_across: f64,
    /// Weight of the movement cost against the gain, 0..=1; the paper's theta (section V.D). Default 0:
    /// moving has no cost.
    pub theta: f64,
    /// Whether to take the view of most expected surface per second, including the time to go there and to
    /// measure, instead of the view of most surface; then theta is 0. Default false.
    pub per_second: bool,
}

impl Default for MostSurfaceConfig {
    fn default() -> Self {
        Self { rays_across: 32.0, theta: 0.0, per_second: false }
    }
}

checked_when_read!(MostSurfaceConfig);

impl MostSurfaceConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        utility::check_theta(self.theta)?;
        if self.per_second && self.theta != 0.0 {
            return Err(Error::invalid("theta", self.theta, "0 with per_second, which counts all the time"));
        }
        check_range("rays_across", self.rays_across, 1.0..=1000.0, "a number in 1..=1000")
    }
}

/// Passes in sequence: the maximum number of views, and the factor on the ray spacing. A pass is skipped if
/// the next one admits all views as well: few views with few rays show too little.
const PASSES: [(usize, f64); 4] = [(usize::MAX, 8.0), (1000, 4.0), (150, 2.0), (24, 1.0)];

/// Minimum gain of a view, second looks included, in voxels.
const LEAST_GAIN: f64 = 0.5;

/// Takes the view that is expected to show the most new surface: the gain
/// [`ExpectedSurface`](crate::gain::ExpectedSurface).
///
/// With a [goal](Situation::goal), the gain of second looks at surface that was not measured well enough is
/// added with a tenth of its weight: new surface comes first. If surface must be [seen several
/// times](Situation::looks), the gain of views that add a look is added as well.
///
/// A view that shows hardly anything of what was expected lowers the expectations for the same voxels.
///
/// Each plan has an [`Outlook`]. Its visible surface is what all views within reach show in the first pass.
/// Its next views are the chosen one, then those expected to add most among a few that are evenly spread.
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
    /// Parts of the last plan, so that no frame is read twice.
    measured: Option<MeasuredParts>,
}

impl MostSurface {
    /// Creates a planner with the library's prior. Fails if a parameter is out of range.
    pub fn new(config: MostSurfaceConfig) -> Result<Self, Error> {
        Self::with_prior(config, SurfacePrior::default())
    }

    /// Creates a planner with a prior of your own. Fails if a parameter is out of range.
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
        let scene = Setting { situation, snapshot: &snapshot, measured, estimate: &estimate };
        let open = situation.open_views();
        let ray_spacing = snapshot.block().dims().max_element() as f64 / self.config.rays_across;
        let first_pass = PASSES.iter().rposition(|(n_views, _)| *n_views >= open.len()).unwrap_or(0);
        let first = scene.survey(&open, PASSES[first_pass].1 * ray_spacing)?;
        let mut rating = Rating::new(&scene, &self.config, first.gains)?;
        for &(n_views, factor) in &PASSES[first_pass + 1..] {
            rating.shortlist(n_views);
            let closer = scene.survey(&rating.views(), factor * ray_spacing)?;
            rating.refine(closer.gains);
        }
        let best = rating.best();
        let outlook = Outlook {
            n_seen: snapshot.count(Occupancy::Occupied),
            n_expected: match &best {
                Some((choice, _)) => forecast::n_expected(&scene, choice.view, &open, ray_spacing)?,
                None => Vec::new(),
            },
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
    /// By view, the value of second looks at what it shows, in voxels; empty if there are none.
    second_looks: Vec<f64>,
    /// Views with their expected gains.
    gains: Vec<(usize, f64)>,
    /// Sum of the values of all views.
    total: f64,
}

impl Rating {
    fn new(
        scene: &Setting<'_>,
        config: &MostSurfaceConfig,
        gains: Vec<(usize, f64)>,
    ) -> Result<Self, Cancelled> {
        let second_looks = second_look::values(scene.situation, scene.snapshot)?;
        let utility = match config.per_second {
            true => Utility::per_second(scene.situation),
            false => Utility::new(scene.situation, config.theta),
        };
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

    /// Replaces the gains by those of denser rays, which meet more voxels: all values grow by the same
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
