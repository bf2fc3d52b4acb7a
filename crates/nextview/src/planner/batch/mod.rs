mod field;
mod trade_off;
mod value;

use super::utility::{check_ray_spacing, check_theta, share};
use super::{Choice, Itinerary, Leg, Plan, Situation, ViewPlanner};
use crate::checked::{check_range, checked_when_read};
use crate::flow::{Coverage, Selection, SetValues, best_coverage, good_coverage};
use crate::{Cancel, Cancelled, Error};
use field::BatchField;
use serde::{Deserialize, Serialize};
use trade_off::TradeOff;
use value::values_of_views;

/// Parameters of [`Batch`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct BatchConfig {
    /// Maximum number of views of a batch, at least 1. Default 5.
    pub n_views: usize,
    /// Weight of the path length against the value of the views, 0..=1. Default 0: the views are ordered for
    /// a short path, but none is left out to shorten it.
    ///
    /// Both are relative to the batch for theta = 0: the score of a batch is (1 - theta) times its relative
    /// value less theta times its relative path length. With 0.2, a view that adds 1 % of the value for more
    /// than 4 % of the path is left out.
    pub theta: f64,
    /// Minimum share, 0..=1, of the value of all views together that a view must add. If no view adds this
    /// much, the batch is the one that adds most. Default 0.01.
    pub least_share: f64,
    /// A session plans again when a view deviates from its expectation by more than this share, at least 0.
    /// Default 0.5.
    pub tolerance: f64,
    /// Distance between neighbouring planning rays at the far side of the box, in voxels as for
    /// [`MostSurface`](super::MostSurface), at least 0.1. Default 2.
    pub ray_spacing: f64,
}

impl Default for BatchConfig {
    fn default() -> Self {
        Self { n_views: 5, theta: 0.0, least_share: 0.01, tolerance: 0.5, ray_spacing: 2.0 }
    }
}

checked_when_read!(BatchConfig);

impl BatchConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        if self.n_views == 0 {
            return Err(Error::invalid("n_views", 0, "at least 1"));
        }
        check_range("least_share", self.least_share, 0.0..=1.0, "a number in 0..=1")?;
        check_range("tolerance", self.tolerance, 0.0..=f64::INFINITY, "a number of at least 0")?;
        check_theta(self.theta)?;
        check_ray_spacing(self.ray_spacing)
    }
}

/// Chooses a few views that together show as much new surface as possible, and a short tour through them.
///
/// The value of a view is the new surface that a learned prior expects it to show, as for
/// [`MostSurface`](super::MostSurface). The views are a [`best_coverage`]. With a weight on the path, they
/// come from a search for a tour with a large score.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    config: BatchConfig,
}

/// A few views to visit in sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchPlan {
    /// In the order of the tour; empty if no view shows anything new.
    pub views: Vec<BatchView>,
    /// Value of these views as a share, 0..=1, of the value of all views together.
    pub share: f64,
    /// Upper bound, to rounding, on the share of any choice of the same number of views.
    pub share_bound: f64,
    /// Length of the tour from the position of the camera, metres.
    pub path_length: f64,
}

/// A view of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchView {
    /// Its number.
    pub view: usize,
    /// Number of surface voxels that it is expected to show after the views before it.
    pub gain: f64,
    /// The gain as a share, 0..=1, of the value of all views together.
    pub share: f64,
}

impl Batch {
    /// Creates a planner. Fails if a parameter is out of range.
    pub fn new(config: BatchConfig) -> Result<Self, Error> {
        config.check()?;
        Ok(Self { config })
    }

    /// Returns the views and the tour, with the tightest bound available.
    ///
    /// Fails if the situation's [`cancel`](Situation::cancel) is set.
    pub fn plan_batch(&self, situation: &Situation<'_>) -> Result<BatchPlan, Cancelled> {
        self.choose(situation, best_coverage)
    }

    /// Returns the views to visit after this candidate, which need not be open itself. There are at most
    /// [`n_views`](BatchConfig::n_views), each the one that adds most to those before it, in the order of a
    /// short tour from the candidate. Their gains are relative to the first view; theta does not count.
    ///
    /// Fails if the situation's [`cancel`](Situation::cancel) is set.
    ///
    /// # Panics
    ///
    /// If the number is not that of a candidate.
    pub fn plan_after(&self, situation: &Situation<'_>, first: usize) -> Result<Vec<BatchView>, Cancelled> {
        let cancel = situation.cancel();
        let others = situation.open_views().into_iter().filter(|&view| view != first);
        let views: Vec<usize> = std::iter::once(first).chain(others).collect();
        let values = values_of_views(situation, &views, self.config.ray_spacing)?;
        let mut field = BatchField::new(situation, &views, &values)?;
        field.start = Some(field.positions[0]);
        let mut selection = Selection::new(&values);
        selection.add(0);
        let mut chosen = Vec::new();
        while chosen.len() < self.config.n_views {
            cancel.check()?;
            let gains = (1..values.n_sets() as u32).map(|set| (set, selection.gain(set)));
            let best = gains.reduce(|best, other| if other.1 > best.1 { other } else { best });
            let is_worthwhile = |gain: f64| gain > 0.0 && gain >= self.least_gain(&field);
            let Some((set, _)) = best.filter(|(_, gain)| is_worthwhile(*gain)) else { break };
            selection.add(set);
            chosen.push(set);
        }
        let tour = field.tour(chosen, cancel)?;
        let mut selection = Selection::new(&values);
        selection.add(0);
        Ok(BatchView::along(&tour, &mut selection, &field, &views))
    }

    fn choose(&self, situation: &Situation<'_>, cover: Cover) -> Result<BatchPlan, Cancelled> {
        let cancel = situation.cancel();
        let open = situation.open_views();
        let values = values_of_views(situation, &open, self.config.ray_spacing)?;
        let field = BatchField::new(situation, &open, &values)?;
        let free = self.without_regard_to_path(&field, cover, cancel)?;
        let tour = if self.config.theta > 0.0 {
            let BatchConfig { theta, n_views, .. } = self.config;
            TradeOff::new(&field, theta, &free.sets, n_views, self.least_gain(&field), cancel)?
                .tour(cancel)?
        } else {
            field.tour(free.sets.clone(), cancel)?
        };
        let bound = if tour.len() == free.sets.len() {
            free.bound
        } else {
            cover(&values, tour.len(), cancel)?.bound
        };
        Ok(BatchPlan::new(&field, &open, &tour, bound))
    }

    /// The views that together show most, up to the first that would add too little.
    fn without_regard_to_path(
        &self,
        field: &BatchField<'_>,
        cover: Cover,
        cancel: &Cancel,
    ) -> Result<Coverage, Cancelled> {
        let all = cover(field.values, self.config.n_views, cancel)?;
        let mut selection = Selection::new(field.values);
        let least_gain = self.least_gain(field);
        let n_views = all.sets.iter().take_while(|&&set| selection.add(set) >= least_gain).count().max(1);
        if n_views < all.sets.len() { cover(field.values, n_views, cancel) } else { Ok(all) }
    }

    fn least_gain(&self, field: &BatchField<'_>) -> f64 {
        self.config.least_share * field.total
    }
}

/// A function that chooses a given number of sets.
type Cover = fn(&SetValues, usize, &Cancel) -> Result<Coverage, Cancelled>;

/// Omits the proof of optimality, which would take longer than the choice.
impl ViewPlanner for Batch {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let views = self.choose(situation, good_coverage)?.views;
        let legs: Vec<Leg> = views.iter().map(BatchView::leg).collect();
        let choice = legs.first().map(|leg| leg.choice.clone());
        Ok(Plan {
            choice,
            itinerary: Some(Itinerary { legs, tolerance: self.config.tolerance }),
            ..Plan::default()
        })
    }
}

impl BatchPlan {
    fn new(field: &BatchField<'_>, open: &[usize], tour: &[u32], bound: f64) -> Self {
        let mut selection = Selection::new(field.values);
        Self {
            views: BatchView::along(tour, &mut selection, field, open),
            share: share(selection.value(), field.total),
            share_bound: share(bound, field.total),
            path_length: field.length(tour),
        }
    }
}

impl BatchView {
    /// Adds the views of a tour to the selection one by one and returns them.
    fn along(
        tour: &[u32],
        selection: &mut Selection<'_>,
        field: &BatchField<'_>,
        views: &[usize],
    ) -> Vec<BatchView> {
        let view = |&set: &u32| {
            let gain = selection.add(set);
            BatchView { view: views[set as usize], gain, share: share(gain, field.total) }
        };
        tour.iter().map(view).collect()
    }

    /// The gain serves as the expectation: about the same part of the expected voxels should become occupied.
    pub(crate) fn leg(&self) -> Leg {
        let Self { view, gain, share } = *self;
        Leg { choice: Choice::new(view, share), expected: gain }
    }
}
