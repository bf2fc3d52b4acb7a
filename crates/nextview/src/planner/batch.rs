use super::utility::{check_ray_spacing, check_theta, share};
use super::worth::worth;
use super::{Choice, Itinerary, Leg, Plan, Situation, ViewPlanner};
use crate::Error;
use crate::flow::{Coverage, Selection, SetValues, best_coverage};
use crate::view::{KeepOut, detour, tour, tour_length};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters of [`Batch`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BatchConfig {
    /// Most views of a batch, at least 1. Default 5.
    pub n_views: usize,
    /// Weight of the path against what the views show, 0..=1. Default 0: the path is short for the views, but no view is
    /// left out to make it shorter.
    ///
    /// Both are measured by the batch for theta = 0: a batch scores (1 - theta) times its worth as a share of that one's, less theta
    /// times its path length as a share of that one's. So with 0.2, a view is left out that adds 1 % of the worth for more than
    /// 4 % of the path.
    pub theta: f64,
    /// A view that would add less than this share, 0..=1, of all that is worth seeing is not added; the first one aside.
    /// Default 0.01.
    pub least_share: f64,
    /// A session plans anew when a view showed less or more than expected by over this share, at least 0. Default 0.5.
    pub tolerance: f64,
    /// Distance between neighbouring planning rays at the far side of the box, in voxels of the finest size, positive.
    /// Default 2, as for [`MaxFlow`](super::MaxFlow).
    pub ray_spacing: f64,
}

impl Default for BatchConfig {
    fn default() -> Self {
        Self { n_views: 5, theta: 0.0, least_share: 0.01, tolerance: 0.5, ray_spacing: 2.0 }
    }
}

/// Chooses a few views that together show as much as possible of what is worth seeing, and a short tour through them.
///
/// What a view shows is the paper's local gain, each voxel counted once. The views are a [`best_coverage`]; with a weight
/// on the path they are inserted one by one into the tour, always the one that adds most to the score.
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
    /// What it shows that those before it do not: local gain, nats.
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
        if !(config.tolerance >= 0.0) {
            return Err(Error::invalid("tolerance", config.tolerance, "a number of at least 0"));
        }
        check_theta(config.theta)?;
        check_ray_spacing(config.ray_spacing)?;
        Ok(Self { config })
    }

    /// The views and the tour.
    pub fn plan_batch(&self, situation: &Situation<'_>) -> BatchPlan {
        let open = situation.open_views();
        let values = worth(situation, &open, self.config.ray_spacing);
        let field = Field::new(situation, &open, &values);
        let free = self.without_regard_to_path(&field);
        let tour = if self.config.theta > 0.0 {
            self.with_regard_to_path(&field, &free)
        } else {
            field.tour(free.sets.clone())
        };
        let bound =
            if tour.len() == free.sets.len() { free.bound } else { best_coverage(&values, tour.len()).bound };
        field.plan(&open, &tour, bound)
    }

    /// As many views as greedy order adds until one would add too little, chosen to show most together.
    fn without_regard_to_path(&self, field: &Field<'_>) -> Coverage {
        let all = best_coverage(field.values, self.config.n_views);
        let mut selection = Selection::new(field.values);
        let adds_enough = |&&set: &&u32| self.adds_enough(field, selection.add(set));
        let n_views = all.sets.iter().take_while(adds_enough).count().max(1);
        if n_views < all.sets.len() { best_coverage(field.values, n_views) } else { all }
    }

    /// The tour of best score that is found by inserting views one by one; or that through the views of `free`, if it scores
    /// more.
    fn with_regard_to_path(&self, field: &Field<'_>, free: &Coverage) -> Vec<u32> {
        let free_tour = field.tour(free.sets.clone());
        let unit = Unit { theta: self.config.theta, worth: free.worth, path: field.length(&free_tour) };
        let inserted = field.tour(self.insert(field, &unit));
        let score = |tour: &[u32]| unit.score(field.values.worth(tour.iter().copied()), field.length(tour));
        if score(&inserted) >= score(&free_tour) { inserted } else { free_tour }
    }

    /// Inserts views where they cost least, always the one of largest score, until none has any.
    fn insert(&self, field: &Field<'_>, unit: &Unit) -> Vec<u32> {
        let (mut tour, mut route): (Vec<u32>, Vec<DVec3>) = (Vec::new(), Vec::new());
        let mut selection = Selection::new(field.values);
        while tour.len() < self.config.n_views {
            let rate = |set: u32| {
                let (gain, position) = (selection.gain(set), field.positions[set as usize]);
                let (place, cost) = detour(field.start, &route, position, &field.ball);
                Insertion { set, place, gain, score: unit.score(gain, cost) }
            };
            let all: Vec<Insertion> = (0..field.values.n_sets() as u32).into_par_iter().map(rate).collect();
            let gaining = all.into_iter().filter(|insertion| insertion.gain > 0.0);
            let best = gaining.reduce(|best, other| if other.score > best.score { other } else { best });
            let is_worth_it = |best: &Insertion| best.score > 0.0 && self.adds_enough(field, best.gain);
            let Some(best) = best.filter(|best| tour.is_empty() || is_worth_it(best)) else { break };
            selection.add(best.set);
            tour.insert(best.place, best.set);
            route.insert(best.place, field.positions[best.set as usize]);
        }
        tour
    }

    fn adds_enough(&self, field: &Field<'_>, gain: f64) -> bool {
        gain >= self.config.least_share * field.total
    }
}

impl ViewPlanner for Batch {
    fn plan(&self, situation: &Situation<'_>) -> Plan {
        let legs: Vec<Leg> = self.plan_batch(situation).views.iter().map(BatchView::leg).collect();
        let choice = legs.first().map(|leg| leg.choice);
        Plan {
            choice,
            itinerary: Some(Itinerary { legs, tolerance: self.config.tolerance }),
            ..Plan::default()
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

/// A view to insert into a tour.
struct Insertion {
    set: u32,
    place: usize,
    gain: f64,
    score: f64,
}

/// What worth and path are measured by.
struct Unit {
    theta: f64,
    worth: f64,
    path: f64,
}

impl Unit {
    fn score(&self, worth: f64, path: f64) -> f64 {
        (1.0 - self.theta) * share(worth, self.worth) - self.theta * share(path, self.path)
    }
}

/// What a batch is chosen from. Sets stand for the open views, in their order.
struct Field<'a> {
    values: &'a SetValues,
    /// Worth of all sets together.
    total: f64,
    positions: Vec<DVec3>,
    start: Option<DVec3>,
    ball: KeepOut,
}

impl<'a> Field<'a> {
    fn new(situation: &Situation<'_>, open: &[usize], values: &'a SetValues) -> Self {
        let bounds = situation.snapshot.lattice().bounds(&situation.snapshot.block());
        Self {
            values,
            total: values.worth(0..values.n_sets() as u32),
            positions: open.iter().map(|&view| situation.views.pose(view).translation()).collect(),
            start: situation.camera_position(),
            ball: KeepOut::around(&bounds, 0.0).expect("a block of voxels is a finite box"),
        }
    }

    fn route(&self, sets: &[u32]) -> Vec<DVec3> {
        sets.iter().map(|&set| self.positions[set as usize]).collect()
    }

    /// The sets in the order of a short tour; of equally short ones, that which begins with the lowest.
    fn tour(&self, mut sets: Vec<u32>) -> Vec<u32> {
        sets.sort_unstable();
        tour(self.start, &self.route(&sets), &self.ball).into_iter().map(|i| sets[i]).collect()
    }

    fn length(&self, tour: &[u32]) -> f64 {
        tour_length(self.start, self.route(tour), &self.ball)
    }

    fn plan(&self, open: &[usize], tour: &[u32], bound: f64) -> BatchPlan {
        let mut selection = Selection::new(self.values);
        let view = |&set: &u32| {
            let gain = selection.add(set);
            BatchView { view: open[set as usize], gain, share: share(gain, self.total) }
        };
        let views = tour.iter().map(view).collect();
        BatchPlan {
            views,
            share: share(selection.worth(), self.total),
            share_bound: share(bound, self.total),
            path_length: self.length(tour),
        }
    }
}
