use super::boundary::boundaries;
use nextview::gain::UnobservedVoxel;
use nextview::map::{Occupancy, frontier};
use nextview::planner::{Choice, Greedy, GreedyConfig, Situation};
use nextview::{Cancelled, Error};

/// Number of features of a state: eight numbers, their products in pairs, and 1.
pub const N_FEATURES: usize = 1 + N_NUMBERS + N_NUMBERS * (N_NUMBERS + 1) / 2;
const N_NUMBERS: usize = 8;

/// Evaluates the views of a scan's successive situations, and describes the state.
#[derive(Clone, Debug)]
pub struct Surveyor {
    gain: Greedy<UnobservedVoxel>,
    ray_spacing: f64,
    before: Option<Before>,
}

/// Data of the scan's earlier situations.
#[derive(Clone, Copy, Debug)]
struct Before {
    /// The largest gain in the first situation.
    first_gain: f64,
    /// Shares of unknown and of frontier voxels in the last situation.
    unknown: f64,
    frontier: f64,
}

/// The open views of a situation with their gains and boundaries, and the features of the situation.
#[derive(Clone, Debug, PartialEq)]
pub struct KabaSurvey {
    views: Vec<ViewValue>,
    features: [f64; N_FEATURES],
}

/// Gain and boundary of a view, as shares of the largest of all open views.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ViewValue {
    view: usize,
    gain: f64,
    boundary: f64,
}

impl Surveyor {
    /// Creates a surveyor for a new scan. `ray_spacing` is the distance between rays at the far side of the
    /// box, in voxels of the finest size, at least 0.1.
    pub fn new(ray_spacing: f64) -> Result<Self, Error> {
        let config = GreedyConfig { ray_spacing, ..GreedyConfig::default() };
        Ok(Self { gain: Greedy::new(config)?, ray_spacing, before: None })
    }

    /// Surveys the next situation of the scan; `None` if no open view gains anything. If cancelled, the
    /// surveyor stays unchanged.
    pub fn survey(&mut self, situation: &Situation<'_>) -> Result<Option<KabaSurvey>, Cancelled> {
        let open = situation.open_views();
        let gains = self.gain.gains(situation, &open)?;
        let best = gains.iter().copied().fold(0.0, f64::max);
        if best <= 0.0 {
            return Ok(None);
        }
        let boundaries = boundaries(situation, &open, self.ray_spacing)?;
        let longest = boundaries.iter().copied().max().unwrap_or(0).max(1) as f64;
        let values = open.iter().zip(&gains).zip(&boundaries).map(|((&view, &gain), &boundary)| ViewValue {
            view,
            gain: gain / best,
            boundary: boundary as f64 / longest,
        });
        let views: Vec<ViewValue> = values.collect();
        let (unknown, frontier) = shares(situation);
        let before = self.before.unwrap_or(Before { first_gain: best, unknown, frontier });
        let n_good = views.iter().filter(|view| view.gain > 0.5).count();
        let numbers = [
            share(
                situation.visited().len(),
                situation.visited().len().saturating_add(situation.n_views_left()),
            ),
            unknown,
            frontier,
            (before.unknown - unknown).clamp(0.0, 1.0),
            (0.5 * (1.0 + before.frontier - frontier)).clamp(0.0, 1.0),
            share(n_good, views.len()),
            (best / before.first_gain).min(1.0),
            largest_gap(situation, &open) / std::f64::consts::PI,
        ];
        self.before = Some(Before { unknown, frontier, ..before });
        Ok(Some(KabaSurvey { views, features: features(&numbers) }))
    }
}

impl KabaSurvey {
    /// Returns the features of the state for a linear value function: 1, the eight numbers of
    /// `docs/methods/kaba.md`, and the products of each with itself and the later ones. All are in 0..=1.
    pub fn features(&self) -> &[f64; N_FEATURES] {
        &self.features
    }

    /// Returns the view with the largest gain minus `boundary_weight` times the boundary it leaves, both as
    /// shares of the largest; the first on ties. Views that gain nothing are left out.
    pub fn choice(&self, boundary_weight: f64) -> Option<Choice> {
        let score = |value: &ViewValue| value.gain - boundary_weight * value.boundary;
        let mut ranked: Vec<&ViewValue> = self.views.iter().filter(|value| value.gain > 0.0).collect();
        ranked.sort_by(|a, b| score(b).total_cmp(&score(a)).then(a.view.cmp(&b.view)));
        ranked.first().map(|best| Choice {
            runner_up: ranked.get(1).map(|second| second.view),
            explanation: Some(
                [
                    ("boundary_share", best.boundary),
                    ("boundary_weight", boundary_weight),
                    ("gain_share", best.gain),
                ]
                .into(),
            ),
            ..Choice::new(best.view, score(best))
        })
    }
}

/// Unknown voxels as a share of the box, and frontier voxels as a share of the occupied ones, at most 1.
fn shares(situation: &Situation<'_>) -> (f64, f64) {
    let snapshot = situation.snapshot();
    let unknown = share(snapshot.count(Occupancy::Unknown), snapshot.occupancy().len());
    (unknown, share(frontier(snapshot).len(), snapshot.count(Occupancy::Occupied)).min(1.0))
}

/// The largest angle, radians, between the direction of an open view from the middle of the box and that of
/// the nearest visited one; pi before the first view.
fn largest_gap(situation: &Situation<'_>, open: &[usize]) -> f64 {
    let snapshot = situation.snapshot();
    let center = snapshot.lattice().bounds(&snapshot.block()).center();
    let direction = |&view: &usize| situation.views().pose(view).translation() - center;
    let gap = |view: &usize| {
        let to = situation.visited().iter().map(|visited| direction(view).angle_between(direction(visited)));
        to.fold(std::f64::consts::PI, f64::min)
    };
    open.iter().map(gap).fold(0.0, f64::max)
}

fn features(numbers: &[f64; N_NUMBERS]) -> [f64; N_FEATURES] {
    let products = (0..N_NUMBERS).flat_map(|a| (a..N_NUMBERS).map(move |b| numbers[a] * numbers[b]));
    let all: Vec<f64> = std::iter::once(1.0).chain(*numbers).chain(products).collect();
    all.try_into().expect("as many as counted")
}

fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(view: usize, gain: f64, boundary: f64) -> ViewValue {
        ViewValue { view, gain, boundary }
    }

    #[test]
    fn weighs_the_boundary_against_the_gain() {
        let views = vec![value(2, 0.9, 0.2), value(3, 1.0, 0.9), value(5, 0.0, 0.0), value(7, 0.9, 0.2)];
        let survey = KabaSurvey { views, features: [0.0; N_FEATURES] };
        let chosen = |weight| survey.choice(weight).map(|choice| (choice.view, choice.runner_up));
        assert_eq!(chosen(0.0), Some((3, Some(2))), "the greedy planner");
        assert_eq!(chosen(0.25), Some((2, Some(7))), "the first on ties");
        let choice = survey.choice(0.5).unwrap();
        assert!((choice.score - 0.8).abs() < 1e-12);
        let nothing = KabaSurvey { views: vec![value(0, 0.0, 0.0)], features: [0.0; N_FEATURES] };
        assert_eq!(nothing.choice(0.0), None);
    }

    #[test]
    fn features_are_one_the_numbers_and_their_products() {
        let mut numbers = [0.0; N_NUMBERS];
        (numbers[0], numbers[7]) = (0.5, 0.25);
        let features = features(&numbers);
        assert_eq!((features[0], features[1], features[8]), (1.0, 0.5, 0.25));
        let products: Vec<f64> = features[9..].iter().copied().filter(|product| *product > 0.0).collect();
        assert_eq!(products, [0.25, 0.125, 0.0625]);
    }
}
