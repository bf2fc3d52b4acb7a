//! Two campaigns, run by run.

use super::campaign::{Campaign, key, measures};
use super::measure::{Better, Measure, PATH, PLAN_TIME, SEEN, SKILL, VIEWS_TO_95, VOXEL_COVERAGE};
use super::statistics::{Interval, mean};
use super::study::{Study, Variant, differences};
use crate::bench::{RunRecord, RunResult};
use serde::Serialize;
use std::collections::BTreeMap;

/// Objects with a difference in voxel coverage above this share are listed.
const LISTED: f64 = 1e-3;

/// Most objects in a list.
const MAX_LISTED: usize = 10;

/// What differs between campaign A and campaign B.
#[derive(Debug, Serialize)]
pub(crate) struct Comparison {
    pub n_runs_a: usize,
    pub n_runs_b: usize,
    /// Runs in both, failed ones included.
    pub n_pairs: usize,
    pub only_in_a: Vec<String>,
    pub only_in_b: Vec<String>,
    /// Runs that failed in one of the two only.
    pub failed_only_in_a: Vec<String>,
    pub failed_only_in_b: Vec<String>,
    /// Whether all pairs are equal apart from times and memory.
    pub pairs_are_identical: bool,
    pub variants: Vec<VariantComparison>,
}

/// A variant in both, or the only one of A against the only one of B.
#[derive(Debug, Serialize)]
pub(crate) struct VariantComparison {
    pub variant_a: String,
    pub variant_b: String,
    /// Objects that have a pair of runs that did not fail.
    pub n_objects: usize,
    pub measures: Vec<MeasureComparison>,
    /// Objects whose voxel coverage is better or worse in B by more than 0.1 point: name and difference in points, the largest
    /// differences first.
    pub better: Vec<(String, f64)>,
    pub worse: Vec<(String, f64)>,
}

/// Means over objects in the shown unit; for the planning time, `difference` and interval are B over A.
#[derive(Debug, Serialize)]
pub(crate) struct MeasureComparison {
    pub name: &'static str,
    pub a: f64,
    pub b: f64,
    pub difference: f64,
    pub interval: Option<Interval>,
    /// Whether the interval leaves out "no difference".
    pub is_more_than_noise: bool,
    /// Whether B is better, as far as the means tell; none if they are equal.
    pub b_is_better: Option<bool>,
    #[serde(skip)]
    pub measure: Measure,
    #[serde(skip)]
    pub is_ratio: bool,
}

const MEASURES: [Measure; 5] = [VOXEL_COVERAGE, SEEN, SKILL, VIEWS_TO_95, PATH];

/// Compares what both have.
pub(crate) fn compare(a: &Campaign, b: &Campaign) -> Comparison {
    let mut b_renamed = b.clone();
    let (names_a, names_b) = (names(a), names(b));
    let mut pairs_of_names: Vec<(String, String)> = names_a
        .iter()
        .filter(|name| names_b.contains(name))
        .map(|name| (name.clone(), name.clone()))
        .collect();
    if let ([one_a], [one_b]) = (&names_a[..], &names_b[..])
        && one_a != one_b
    {
        b_renamed.runs.iter_mut().for_each(|run| run.variant.clone_from(one_a));
        pairs_of_names.push((one_a.clone(), one_b.clone()));
    }
    let pairing = Pairing::new(a, &b_renamed);
    let done = |run: &RunRecord| measures(run).is_some();
    let failed = |bad: fn(&Pair<'_>) -> (bool, bool)| {
        let failed = pairing.pairs.iter().filter(|pair| bad(pair) == (false, true));
        failed.map(|pair| label(pair.0)).collect()
    };
    let both_done: Vec<Pair<'_>> =
        pairing.pairs.iter().copied().filter(|(a, b)| done(a) && done(b)).collect();
    let campaign =
        |runs: Vec<RunRecord>, of: &Campaign| Campaign { runs, name: of.name.clone(), torn: of.torn };
    let paired_a = campaign(both_done.iter().map(|pair| pair.0.clone()).collect(), a);
    let paired_b = campaign(both_done.iter().map(|pair| pair.1.clone()).collect(), b);
    let (study_a, study_b) = (Study::new(&paired_a), Study::new(&paired_b));
    let variants = pairs_of_names.into_iter().filter_map(|(name_a, name_b)| {
        let find = |study: &'_ Study<'_>| study.variants.iter().position(|v| v.name == name_a);
        let (in_a, in_b) = (&study_a.variants[find(&study_a)?], &study_b.variants[find(&study_b)?]);
        Some(VariantComparison::new(name_a, name_b, &study_a, in_a, in_b))
    });
    Comparison {
        n_runs_a: a.runs.len(),
        n_runs_b: b.runs.len(),
        n_pairs: pairing.pairs.len(),
        failed_only_in_a: failed(|(a, b)| (measures(a).is_some(), measures(b).is_some())),
        failed_only_in_b: failed(|(a, b)| (measures(b).is_some(), measures(a).is_some())),
        pairs_are_identical: pairing.pairs.iter().all(|(a, b)| timeless(a) == timeless(b)),
        variants: variants.collect(),
        only_in_a: pairing.only_in_a,
        only_in_b: pairing.only_in_b,
    }
}

impl Comparison {
    /// Whether A and B hold the same runs with the same results, apart from times and memory.
    pub fn is_identical(&self) -> bool {
        self.pairs_are_identical && self.only_in_a.is_empty() && self.only_in_b.is_empty()
    }
}

type Pair<'a> = (&'a RunRecord, &'a RunRecord);

struct Pairing<'a> {
    pairs: Vec<Pair<'a>>,
    only_in_a: Vec<String>,
    only_in_b: Vec<String>,
}

impl<'a> Pairing<'a> {
    fn new(a: &'a Campaign, b: &'a Campaign) -> Self {
        let by_key = |campaign: &'a Campaign| -> BTreeMap<_, _> {
            campaign.runs.iter().map(|run| (key(run), run)).collect()
        };
        let (a, b) = (by_key(a), by_key(b));
        let only = |own: &BTreeMap<_, &'a RunRecord>, other: &BTreeMap<_, &'a RunRecord>| {
            own.iter().filter(|(key, _)| !other.contains_key(*key)).map(|(_, run)| label(run)).collect()
        };
        Self {
            pairs: a.iter().filter_map(|(key, &run)| Some((run, *b.get(key)?))).collect(),
            only_in_a: only(&a, &b),
            only_in_b: only(&b, &a),
        }
    }
}

fn names(campaign: &Campaign) -> Vec<String> {
    let mut names: Vec<String> = campaign.runs.iter().map(|run| run.variant.clone()).collect();
    names.sort();
    names.dedup();
    names
}

fn label(run: &RunRecord) -> String {
    format!("{} on {}, seed {}, first view {}", run.variant, run.object, run.seed, run.first_view)
}

/// The result without times and memory.
fn timeless(run: &RunRecord) -> RunResult {
    let mut result = run.result.clone();
    if let RunResult::Done(measures) = &mut result {
        measures.extra_memory_mb = None;
        for step in &mut measures.steps {
            (step.plan_time_ms, step.map_time_ms, step.render_time_ms) = (0.0, 0.0, 0.0);
            // Campaigns of old have none.
            (step.way_m, step.move_time_s) = (None, None);
        }
    }
    result
}

impl VariantComparison {
    fn new(
        variant_a: String,
        variant_b: String,
        study: &Study<'_>,
        a: &Variant<'_>,
        b: &Variant<'_>,
    ) -> Self {
        let mut measures: Vec<MeasureComparison> =
            MEASURES.iter().filter_map(|measure| MeasureComparison::difference(measure, a, b)).collect();
        measures.extend(MeasureComparison::ratio(&PLAN_TIME, a, b));
        let (in_a, in_b) = (a.by_object(&VOXEL_COVERAGE), b.by_object(&VOXEL_COVERAGE));
        let points = |(object, (a, b)): (&super::study::Object<'_>, (&Option<f64>, &Option<f64>))| {
            Some((object.name.to_owned(), (*b)? - (*a)?))
        };
        let mut by_object: Vec<(String, f64)> =
            study.objects.iter().zip(in_a.iter().zip(&in_b)).filter_map(points).collect();
        by_object.sort_by(|a, b| b.1.total_cmp(&a.1));
        let listed = |(name, d): &(String, f64)| (name.clone(), 100.0 * d);
        Self {
            variant_a,
            variant_b,
            n_objects: a.n_objects(),
            measures,
            better: by_object.iter().filter(|d| d.1 > LISTED).take(MAX_LISTED).map(listed).collect(),
            worse: by_object.iter().rev().filter(|d| d.1 < -LISTED).take(MAX_LISTED).map(listed).collect(),
        }
    }
}

impl MeasureComparison {
    fn difference(measure: &Measure, a: &Variant<'_>, b: &Variant<'_>) -> Option<Self> {
        let (in_a, in_b) = (a.by_object(measure), b.by_object(measure));
        let differences = differences(&in_b, &in_a);
        let shown = |value: f64| measure.factor * value;
        let interval = Interval::of_mean(&differences);
        Self::new(measure, [&in_a, &in_b], mean(&differences)?, interval).map(|comparison| Self {
            difference: shown(comparison.difference),
            interval: interval.map(|interval| interval.map(shown)),
            ..comparison
        })
    }

    /// Ratios are averaged as powers, so that half and double cancel.
    fn ratio(measure: &Measure, a: &Variant<'_>, b: &Variant<'_>) -> Option<Self> {
        let logarithms = |variant: &Variant<'_>| -> Vec<Option<f64>> {
            let values = variant.by_object(measure).into_iter();
            values.map(|value| value.filter(|&value| value > 0.0).map(f64::ln)).collect()
        };
        let (in_a, in_b) = (a.by_object(measure), b.by_object(measure));
        let differences = differences(&logarithms(b), &logarithms(a));
        let interval = Interval::of_mean(&differences);
        Self::new(measure, [&in_a, &in_b], mean(&differences)?, interval).map(|comparison| Self {
            difference: comparison.difference.exp(),
            interval: interval.map(|interval| interval.map(f64::exp)),
            is_ratio: true,
            ..comparison
        })
    }

    fn new(
        measure: &Measure,
        [a, b]: [&[Option<f64>]; 2],
        difference: f64,
        interval: Option<Interval>,
    ) -> Option<Self> {
        let both = || a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
        let is_better = match measure.better {
            Better::Higher => difference > 0.0,
            Better::Lower => difference < 0.0,
        };
        Some(Self {
            name: measure.name,
            a: measure.factor * mean(&both().map(|pair| pair.0).collect::<Vec<_>>())?,
            b: measure.factor * mean(&both().map(|pair| pair.1).collect::<Vec<_>>())?,
            difference,
            interval,
            is_more_than_noise: interval.is_some_and(|interval| interval.excludes_zero()),
            b_is_better: (difference.abs() > 1e-12).then_some(is_better),
            measure: *measure,
            is_ratio: false,
        })
    }
}
