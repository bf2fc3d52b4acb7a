use super::measure::{
    Better, Measure, PATH, PLAN_TIME, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, VOXEL_COVERAGE,
};
use super::pairing::{Pair, Pairing};
use super::{
    Comparison, Interval, MeasureComparison, Study, StudyObject, StudyVariant, VariantComparison,
    differences, mean,
};
use crate::RunRecord;

/// Objects with a difference in voxel coverage above this share are listed.
const LISTED: f64 = 1e-3;

/// Most objects in a list.
const MAX_LISTED: usize = 10;

const MEASURES: [Measure; 5] = [VOXEL_COVERAGE, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, PATH];

/// Compares the runs that campaign A and campaign B have in common.
pub fn compare<'a>(
    a: impl IntoIterator<Item = &'a RunRecord>,
    b: impl IntoIterator<Item = &'a RunRecord>,
) -> Comparison {
    let (a, b): (Vec<&RunRecord>, Vec<&RunRecord>) = (a.into_iter().collect(), b.into_iter().collect());
    let pairing = Pairing::new(&a, &b);
    let is_done = |run: &RunRecord| run.done().is_some();
    let labels = |runs: &[&RunRecord]| runs.iter().map(|run| label(run)).collect();
    let failed = |is_done_in: fn(&Pair<'_>) -> (bool, bool)| {
        let failed = pairing.pairs.iter().filter(|pair| is_done_in(pair) == (false, true));
        failed.map(|pair| label(pair.0)).collect()
    };
    let both_done = || pairing.pairs.iter().filter(|(a, b)| is_done(a) && is_done(b));
    let study_a = Study::new(both_done().map(|pair| pair.0));
    let study_b = Study::new(both_done().map(|pair| pair.1));
    let compared = pairing.variants.iter().filter_map(|(name_a, name_b)| {
        Some(of_variant(&Side::new(&study_a, name_a)?, &Side::new(&study_b, name_b)?))
    });
    Comparison {
        n_runs_a: a.len(),
        n_runs_b: b.len(),
        n_pairs: pairing.pairs.len(),
        failed_only_in_a: failed(|(a, b)| (a.done().is_some(), b.done().is_some())),
        failed_only_in_b: failed(|(a, b)| (b.done().is_some(), a.done().is_some())),
        pairs_are_identical: pairing.pairs.iter().all(|(a, b)| a.has_same_results(b)),
        variants: compared.collect(),
        only_in_a: labels(&pairing.only_in_a),
        only_in_b: labels(&pairing.only_in_b),
    }
}

fn label(run: &RunRecord) -> String {
    format!("{} on {}, seed {}, first view {}", run.variant, run.object, run.seed, run.first_view)
}

/// A variant in the study of its campaign.
struct Side<'s, 'a> {
    objects: &'s [StudyObject<'a>],
    variant: &'s StudyVariant<'a>,
}

impl<'s, 'a> Side<'s, 'a> {
    fn new(study: &'s Study<'a>, name: &str) -> Option<Self> {
        let variant = study.variants.iter().find(|variant| variant.name == name)?;
        Some(Self { objects: &study.objects, variant })
    }

    /// The measure for each of these objects; data sets may have other names here.
    fn by_object(&self, measure: &Measure, objects: &[StudyObject<'_>]) -> Vec<Option<f64>> {
        let own = self.variant.by_object(measure);
        let number = |object: &StudyObject<'_>| self.objects.iter().position(|own| own.name == object.name);
        objects.iter().map(|object| own[number(object)?]).collect()
    }
}

fn of_variant(a: &Side<'_, '_>, b: &Side<'_, '_>) -> VariantComparison {
    let both = |measure: &Measure| [a, b].map(|side| side.by_object(measure, a.objects));
    let mut measures: Vec<MeasureComparison> =
        MEASURES.iter().filter_map(|measure| difference(measure, both(measure))).collect();
    measures.extend(ratio(&PLAN_TIME, both(&PLAN_TIME)));
    let [in_a, in_b] = both(&VOXEL_COVERAGE);
    let by_object = a.objects.iter().zip(in_a.iter().zip(&in_b));
    let mut by_object: Vec<(&str, f64)> =
        by_object.filter_map(|(object, (a, b))| Some((object.name, (*b)? - (*a)?))).collect();
    by_object.sort_by(|a, b| b.1.total_cmp(&a.1));
    let listed = |(name, difference): &(&str, f64)| ((*name).to_owned(), 100.0 * difference);
    VariantComparison {
        variant_a: a.variant.name.to_owned(),
        variant_b: b.variant.name.to_owned(),
        n_objects: a.variant.n_objects(),
        measures,
        better: by_object.iter().filter(|d| d.1 > LISTED).take(MAX_LISTED).map(listed).collect(),
        worse: by_object.iter().rev().filter(|d| d.1 < -LISTED).take(MAX_LISTED).map(listed).collect(),
    }
}

fn difference(measure: &Measure, [a, b]: [Vec<Option<f64>>; 2]) -> Option<MeasureComparison> {
    let differences = differences(&b, &a);
    let shown = |value: f64| measure.factor * value;
    let interval = Interval::of_mean(&differences);
    let comparison = of_measure(measure, [&a, &b], mean(&differences)?, interval)?;
    Some(MeasureComparison {
        difference: shown(comparison.difference),
        interval: interval.map(|interval| interval.map(shown)),
        ..comparison
    })
}

/// Ratios are averaged as powers, so that half and double cancel.
fn ratio(measure: &Measure, [a, b]: [Vec<Option<f64>>; 2]) -> Option<MeasureComparison> {
    let logarithms = |values: &[Option<f64>]| -> Vec<Option<f64>> {
        values.iter().map(|value| value.filter(|&value| value > 0.0).map(f64::ln)).collect()
    };
    let differences = differences(&logarithms(&b), &logarithms(&a));
    let interval = Interval::of_mean(&differences);
    let comparison = of_measure(measure, [&a, &b], mean(&differences)?, interval)?;
    Some(MeasureComparison {
        difference: comparison.difference.exp(),
        interval: interval.map(|interval| interval.map(f64::exp)),
        is_ratio: true,
        ..comparison
    })
}

fn of_measure(
    measure: &Measure,
    [a, b]: [&[Option<f64>]; 2],
    difference: f64,
    interval: Option<Interval>,
) -> Option<MeasureComparison> {
    let both = || a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
    let is_better = match measure.better {
        Better::Higher => difference > 0.0,
        Better::Lower => difference < 0.0,
    };
    Some(MeasureComparison {
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
