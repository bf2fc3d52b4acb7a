use super::measure::{
    Better, Measure, PATH, PLAN_TIME, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, VOXEL_COVERAGE,
};
use super::pairing::{Pair, Pairing};
use super::study::paired;
use super::{
    Comparison, Interval, MeasureComparison, MeasuredRun, PairedSample, Study, StudyObject, StudyVariant,
    VariantComparison, mean, percentile,
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
    let RunRecord { variant, object, seed, view_seed, first_view, .. } = run;
    format!("{variant} on {object}, seed {seed}, view seed {view_seed}, first view {first_view}")
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

    /// The runs on the object of this name; the data set may have another name here.
    fn runs_on(&self, object: &str) -> &'s [MeasuredRun<'a>] {
        let number = self.objects.iter().position(|own| own.name == object);
        number.map_or(&[][..], |number| &self.variant.runs[number][..])
    }
}

fn of_variant(a: &Side<'_, '_>, b: &Side<'_, '_>) -> VariantComparison {
    let both = |measure: &Measure| {
        let of_object =
            |object: &StudyObject<'_>| paired(a.runs_on(object.name), b.runs_on(object.name), measure);
        PairedSample::new(a.objects.iter().filter_map(of_object))
    };
    let mut measures: Vec<MeasureComparison> =
        MEASURES.iter().filter_map(|measure| difference(measure, &both(measure))).collect();
    measures.extend(ratio(&PLAN_TIME, &both(&PLAN_TIME).positive()));
    let coverage = |object: &StudyObject<'_>| {
        let pair = paired(a.runs_on(object.name), b.runs_on(object.name), &VOXEL_COVERAGE)?;
        Some((object.name.to_owned(), PairedSample::new([pair]).differences()[0]))
    };
    let mut by_object: Vec<(String, f64)> = a.objects.iter().filter_map(coverage).collect();
    by_object.sort_by(|a, b| b.1.total_cmp(&a.1));
    let listed = |(name, difference): &(String, f64)| (name.clone(), 100.0 * difference);
    VariantComparison {
        variant_a: a.variant.name.to_owned(),
        variant_b: b.variant.name.to_owned(),
        n_objects: a.variant.n_objects(),
        measures,
        better: by_object.iter().filter(|d| d.1 > LISTED).take(MAX_LISTED).map(listed).collect(),
        worse: by_object.iter().rev().filter(|d| d.1 < -LISTED).take(MAX_LISTED).map(listed).collect(),
    }
}

fn difference(measure: &Measure, pairs: &PairedSample) -> Option<MeasureComparison> {
    let differences = pairs.differences();
    let shown = |value: f64| measure.factor * value;
    let interval = pairs.interval().map(|interval| interval.map(shown));
    let [mean, median] = [mean(&differences)?, percentile(&differences, 0.5)?].map(shown);
    Some(MeasureComparison {
        is_more_than_noise: interval.is_some_and(|interval| interval.excludes_zero()),
        ..of_measure(measure, pairs, [mean, median], 0.0, interval)?
    })
}

/// Of times: the ratio of the means that are shown, and the median of the ratios of the objects.
fn ratio(measure: &Measure, pairs: &PairedSample) -> Option<MeasureComparison> {
    let ratios: Vec<f64> = pairs.of_a().iter().zip(pairs.of_b()).map(|(a, b)| b / a).collect();
    let (ratios, interval) = ([pairs.ratio()?, percentile(&ratios, 0.5)?], pairs.ratio_interval());
    Some(MeasureComparison {
        is_more_than_noise: interval.is_some_and(|interval| interval.excludes(1.0)),
        is_ratio: true,
        ..of_measure(measure, pairs, ratios, 1.0, interval)?
    })
}

/// The comparison of these differences or ratios, mean and median; `equal` is no difference.
fn of_measure(
    measure: &Measure,
    pairs: &PairedSample,
    [difference, median_difference]: [f64; 2],
    equal: f64,
    interval: Option<Interval>,
) -> Option<MeasureComparison> {
    let (a, b) = (pairs.of_a(), pairs.of_b());
    let is_better = match measure.better {
        Better::Higher => difference > equal,
        Better::Lower => difference < equal,
    };
    Some(MeasureComparison {
        name: measure.name,
        a: measure.factor * mean(&a)?,
        b: measure.factor * mean(&b)?,
        median_a: measure.factor * percentile(&a, 0.5)?,
        median_b: measure.factor * percentile(&b, 0.5)?,
        difference,
        median_difference,
        interval,
        test: pairs.signed_rank()?,
        is_more_than_noise: false,
        b_is_better: ((difference - equal).abs() > 1e-12).then_some(is_better),
        is_ratio: false,
        measure: *measure,
    })
}
