use super::field::Field;
use super::trade_off::TradeOff;
use super::utility::{check_ray_spacing, check_theta, share};
use super::worth::worth;
use super::{Choice, Itinerary, Leg, Plan, Situation, ViewPlanner};
use crate::Error;
use crate::flow::{Coverage, Selection, SetValues, best_coverage, good_coverage};
use serde::{Deserialize, Serialize};

/// Parameters of [`Batch`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BatchConfig {
    /// Most views of a batch, at least 1. Default 5.
    pub n_views: usize,
    /// Weight of the path against what the views show, 0..=1. Default 0: the path is short for the views, but no view
    /// is left out to make it shorter.
    ///
    /// Both are measured by the batch for theta = 0: a batch scores (1 - theta) times its worth as a share of that
    /// one's, less theta times its path length as a share of that one's. So with 0.2, a view is left out that adds 1 %
    /// of the worth for more than 4 % of the path.
    pub theta: f64,
    /// A view that would add less than this share, 0..=1, of all that is worth seeing is not added; if no view adds as
    /// much, the batch is the one that adds most. Default 0.01.
    pub least_share: f64,
    /// A session plans anew when a view showed less or more than expected by over this share, at least 0. Default 0.5.
    pub tolerance: f64,
    /// Distance between neighbouring planning rays at the far side of the box, in voxels as for
    /// [`MostSurface`](super::MostSurface), positive. Default 2.
    pub ray_spacing: f64,
}

impl Default for BatchConfig {
    fn default() -> Self {
        Self { n_views: 5, theta: 0.0, least_share: 0.01, tolerance: 0.5, ray_spacing: 2.0 }
    }
}

/// Chooses a few views that together show as much as possible of what is worth seeing, and a short tour through them.
///
/// What a view shows is what a learned prior expects it to show anew, as for [`MostSurface`](super::MostSurface). The
/// views are a [`best_coverage`]; with a weight on the path, a tour of large score is searched for.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    config: BatchConfig,
}

/// A few views to be visited one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchPlan {
    /// In the order of the tour; none if no view shows anything of worth.
    pub views: Vec<BatchView>,
    /// The part, 0..=1, of all that is worth seeing from any view that these show.
    pub share: f64,
    /// No choice of as many views shows a larger part, to rounding.
    pub share_bound: f64,
    /// Length of the tour from where the camera is, metres.
    pub path_length: f64,
}

/// A view of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchView {
    /// Its number.
    pub view: usize,
    /// What it is expected to show that those before it do not: voxels of surface.
    pub gain: f64,
    /// The same as a part, 0..=1, of all that is worth seeing.
    pub share: f64,
}

impl Batch {
    /// A planner with checked parameters.
    pub fn new(config: BatchConfig) -> Result<Self, Error> {
        if config.n_views == 0 {
            return Err(Error::invalid("n_views", 0, "at least 1"));
        }
        if !(0.0..=1.0).contains(&config.least_share) {
            return Err(Error::invalid("least_share", config.least_share, "a number in 0..=1"));
        }
        if !(0.0..=f64::INFINITY).contains(&config.tolerance) {
            return Err(Error::invalid("tolerance", config.tolerance, "a number of at least 0"));
        }
        check_theta(config.theta)?;
        check_ray_spacing(config.ray_spacing)?;
        Ok(Self { config })
    }

    /// The views and the tour, with the best bound there is.
    pub fn plan_batch(&self, situation: &Situation<'_>) -> BatchPlan {
        self.choose(situation, best_coverage)
    }

    fn choose(&self, situation: &Situation<'_>, cover: Cover) -> BatchPlan {
        let open = situation.open_views();
        let values = worth(situation, &open, self.config.ray_spacing);
        let field = Field::new(situation, &open, &values);
        let free = self.without_regard_to_path(&field, cover);
        let tour = if self.config.theta > 0.0 {
            let BatchConfig { theta, n_views, .. } = self.config;
            TradeOff::new(&field, theta, &free.sets, n_views, self.least_gain(&field)).tour()
        } else {
            field.tour(free.sets.clone())
        };
        let bound = if tour.len() == free.sets.len() { free.bound } else { cover(&values, tour.len()).bound };
        BatchPlan::new(&field, &open, &tour, bound)
    }

    /// As many views as are added, the best first, until one would add too little; chosen to show most together.
    fn without_regard_to_path(&self, field: &Field<'_>, cover: Cover) -> Coverage {
        let all = cover(field.values, self.config.n_views);
        let mut selection = Selection::new(field.values);
        let least_gain = self.least_gain(field);
        let n_views = all.sets.iter().take_while(|&&set| selection.add(set) >= least_gain).count().max(1);
        if n_views < all.sets.len() { cover(field.values, n_views) } else { all }
    }

    fn least_gain(&self, field: &Field<'_>) -> f64 {
        self.config.least_share * field.total
    }
}

/// A way to choose so many sets.
type Cover = fn(&SetValues, usize) -> Coverage;

/// Without the proof of how good the choice is, which would take longer than the choice.
impl ViewPlanner for Batch {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let legs: Vec<Leg> = self.choose(situation, good_coverage).views.iter().map(BatchView::leg).collect();
        let choice = legs.first().map(|leg| leg.choice);
        Plan {
            choice,
            itinerary: Some(Itinerary { legs, tolerance: self.config.tolerance }),
            ..Plan::default()
        }
    }
}

impl BatchPlan {
    fn new(field: &Field<'_>, open: &[usize], tour: &[u32], bound: f64) -> Self {
        let mut selection = Selection::new(field.values);
        let view = |&set: &u32| {
            let gain = selection.add(set);
            BatchView { view: open[set as usize], gain, share: share(gain, field.total) }
        };
        Self {
            views: tour.iter().map(view).collect(),
            share: share(selection.worth(), field.total),
            share_bound: share(bound, field.total),
            path_length: field.length(tour),
        }
    }
}

impl BatchView {
    /// Of as many voxels seen, about the same part should turn out to be occupied.
    fn leg(&self) -> Leg {
        let Self { view, gain, share } = *self;
        let choice = Choice { view, score: share, local_share: share, flow_share: 0.0, runner_up: None };
        Leg { choice, expected: gain }
    }
}
