use super::{Choice, Situation};
use crate::Error;
use crate::checked::check_range;
use rayon::prelude::*;

/// The value of a view after the cost of moving there.
#[derive(Debug)]
pub(super) enum Utility {
    /// (1 - theta) times its share of all gain, less theta times its share of the travel cost of all views:
    /// the paper, section V.D.
    LessTravel {
        theta: f64,
        /// By view; zeros if moving costs nothing.
        travel_share: Vec<f64>,
    },
    /// Its share of all gain, divided by the seconds until it is measured.
    PerSecond { seconds: Vec<f64> },
}

impl Utility {
    /// The utility per second; 0 for views that cannot be reached.
    pub fn per_second(situation: &Situation<'_>) -> Self {
        let mut seconds = vec![f64::INFINITY; situation.views().len()];
        let open = situation.open_views();
        let times: Vec<f64> = open.par_iter().map(|&view| situation.seconds(view)).collect();
        open.iter().zip(times).for_each(|(&view, time)| seconds[view] = time);
        Self::PerSecond { seconds }
    }

    /// The utility less the cost of travel. The costs are [those](Situation::travel) of the open views, as
    /// shares of their sum; all are zero before the first view.
    pub fn new(situation: &Situation<'_>, theta: f64) -> Self {
        let mut travel_share = vec![0.0; situation.views().len()];
        let open = situation.open_views();
        let travel: Vec<f64> = open.iter().filter_map(|&view| situation.travel(view)).collect();
        let total: f64 = travel.iter().sum();
        open.iter().zip(&travel).for_each(|(&view, travel)| travel_share[view] = share(*travel, total));
        Self::LessTravel { theta, travel_share }
    }

    /// The utility of a view with this share of all gain; exactly the share if theta is 0.
    pub fn of(&self, view: usize, gain_share: f64) -> f64 {
        match self {
            Self::LessTravel { theta, travel_share } => {
                (1.0 - theta) * gain_share - theta * travel_share[view]
            }
            Self::PerSecond { seconds } => gain_share / seconds[view],
        }
    }
}

/// Fails unless theta is in 0..=1.
pub(super) fn check_theta(theta: f64) -> Result<(), Error> {
    if (0.0..=1.0).contains(&theta) {
        return Ok(());
    }
    Err(Error::invalid("theta", theta, "a number in 0..=1"))
}

/// Minimum distance between planning rays, voxels: a hundred rays then meet every voxel, fifty times the
/// number needed to [miss none](crate::visibility::NO_VOXEL_MISSED).
const LEAST_SPACING: f64 = 0.1;

/// Fails unless the ray spacing is valid.
pub(super) fn check_ray_spacing(ray_spacing: f64) -> Result<(), Error> {
    check_range("ray_spacing", ray_spacing, LEAST_SPACING..=f64::MAX, "a number of voxels, at least 0.1")
}

/// A share of a total that may be zero.
pub(super) fn share(value: f64, total: f64) -> f64 {
    if total > 0.0 { value / total } else { 0.0 }
}

/// The choice of largest score, the first on ties, with the second best as its runner-up.
pub(super) fn best(choices: impl Iterator<Item = Choice>) -> Option<Choice> {
    let (mut best, mut second): (Option<Choice>, Option<Choice>) = (None, None);
    for choice in choices {
        if best.as_ref().is_none_or(|best| choice.score > best.score) {
            second = best.replace(choice);
        } else if second.as_ref().is_none_or(|second| choice.score > second.score) {
            second = Some(choice);
        }
    }
    best.map(|best| Choice { runner_up: second.map(|choice| choice.view), ..best })
}
