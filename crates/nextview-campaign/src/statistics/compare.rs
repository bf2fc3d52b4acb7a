use super::measure::{
    Better, Measure, PATH, PLAN_TIME, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, VOXEL_COVERAGE,
};
use super::study::paired;
use super::{
    Comparison, Interval, MeasureComparison, MeasuredRun, PairedSample, Study, StudyBuilder, StudyObject,
    StudyVariant, VariantComparison, mean, percentile,
};
use crate::store::StoredRuns;
use crate::{RunId, RunRecord};
use nextview_scan::Fault;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Objects with a difference in voxel coverage above this share are listed.
const LISTED: f64 = 1e-3;

/// Most objects in a list.
const MAX_LISTED: usize = 10;

const MEASURES: [Measure; 5] = [VOXEL_COVERAGE, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, PATH];

/// Compares the runs that campaign A and campaign B have in common. Both are read once, side by side.
pub fn compare(a: &StoredRuns, b: &StoredRuns) -> Result<Comparison, Fault> {
    let (variants, renamed) = variants(a, b);
    let mut found = Found::default();
    // Both are in the order of the identities, also where B's only variant has another name.
    let (mut runs_a, mut runs_b) = (a.runs.iter(), b.runs.iter());
    let (mut next_a, mut next_b) = (runs_a.next().transpose()?, runs_b.next().transpose()?);
    loop {
        let order = match (&next_a, &next_b) {
            (None, None) => break,
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (Some(a), Some(b)) => a.id().cmp(&id_in_a(b, renamed)),
        };
        let run_a = next_a.take_if(|_| order.is_le());
        let run_b = next_b.take_if(|_| order.is_ge());
        if run_a.is_some() {
            next_a = runs_a.next().transpose()?;
        }
        if run_b.is_some() {
            next_b = runs_b.next().transpose()?;
        }
        found.add(run_a, run_b);
    }
    let (study_a, study_b) = (found.study_a.build(), found.study_b.build());
    let compared = variants.iter().filter_map(|(name_a, name_b)| {
        Some(of_variant(&Side::new(&study_a, name_a)?, &Side::new(&study_b, name_b)?))
    });
    Ok(Comparison {
        n_runs_a: a.runs.len(),
        n_runs_b: b.runs.len(),
        n_pairs: found.n_pairs,
        failed_only_in_a: found.failed_only_in_a,
        failed_only_in_b: found.failed_only_in_b,
        pairs_are_identical: !found.has_unequal_pair,
        variants: compared.collect(),
        only_in_a: found.only_in_a,
        only_in_b: found.only_in_b,
    })
}

/// The names of the variants that are compared: those of one name, or the only one of A with the only one of
/// B, of which the name in A is the second value then.
fn variants<'a>(a: &'a StoredRuns, b: &'a StoredRuns) -> (Vec<(&'a str, &'a str)>, Option<&'a str>) {
    let common = a.variants.iter().filter(|name| b.variants.contains(*name));
    let mut variants: Vec<(&str, &str)> = common.map(|name| (&name[..], &name[..])).collect();
    let only = |runs: &'a StoredRuns| runs.variants.first().filter(|_| runs.variants.len() == 1);
    match (only(a), only(b)) {
        (Some(of_a), Some(of_b)) if of_a != of_b => {
            variants.push((of_a, of_b));
            (variants, Some(of_a))
        }
        _ => (variants, None),
    }
}

/// The identity that a run of B has in A.
fn id_in_a(run: &RunRecord, renamed: Option<&str>) -> RunId {
    let id = run.id();
    RunId { variant: renamed.map_or(id.variant, str::to_owned), ..id }
}

/// What was found in both campaigns so far.
#[derive(Default)]
struct Found {
    study_a: StudyBuilder,
    study_b: StudyBuilder,
    n_pairs: usize,
    only_in_a: Vec<String>,
    only_in_b: Vec<String>,
    failed_only_in_a: Vec<String>,
    failed_only_in_b: Vec<String>,
    has_unequal_pair: bool,
}

impl Found {
    /// The next run, of A, of B, or of both.
    fn add(&mut self, a: Option<RunRecord>, b: Option<RunRecord>) {
        match (a, b) {
            (Some(a), Some(b)) => self.add_pair(&a, &b),
            (Some(a), None) => self.only_in_a.push(label(&a)),
            (None, Some(b)) => self.only_in_b.push(label(&b)),
            (None, None) => (),
        }
    }

    fn add_pair(&mut self, a: &RunRecord, b: &RunRecord) {
        self.n_pairs += 1;
        self.has_unequal_pair |= !a.has_same_results(b);
        match (a.done().is_some(), b.done().is_some()) {
            (true, true) => {
                self.study_a.add(a);
                self.study_b.add(b);
            }
            (false, true) => self.failed_only_in_a.push(label(a)),
            (true, false) => self.failed_only_in_b.push(label(a)),
            (false, false) => (),
        }
    }
}

fn label(run: &RunRecord) -> String {
    let RunRecord { variant, object, seed, view_seed, first_view, .. } = run;
    format!("{variant} on {object}, seed {seed}, view seed {view_seed}, first view {first_view}")
}

/// A variant in the study of its campaign.
struct Side<'s> {
    objects: BTreeMap<&'s str, usize>,
    study: &'s Study,
    variant: &'s StudyVariant,
}

impl<'s> Side<'s> {
    fn new(study: &'s Study, name: &str) -> Option<Self> {
        let variant = study.variants.iter().find(|variant| variant.name == name)?;
        let objects = study.objects.iter().map(|object| &object.name[..]).zip(0..).collect();
        Some(Self { objects, study, variant })
    }

    /// The runs on the object of this name; the data set may have another name here.
    fn runs_on(&self, object: &str) -> &'s [MeasuredRun] {
        self.objects.get(object).map_or(&[][..], |&number| &self.variant.runs[number][..])
    }
}

fn of_variant(a: &Side<'_>, b: &Side<'_>) -> VariantComparison {
    let both = |measure: &Measure| {
        let of_object =
            |object: &StudyObject| paired(a.runs_on(&object.name), b.runs_on(&object.name), measure);
        PairedSample::new(a.study.objects.iter().filter_map(of_object))
    };
    let mut measures: Vec<MeasureComparison> =
        MEASURES.iter().filter_map(|measure| difference(measure, &both(measure))).collect();
    measures.extend(ratio(&PLAN_TIME, &both(&PLAN_TIME).positive()));
    let coverage = |object: &StudyObject| {
        let pair = paired(a.runs_on(&object.name), b.runs_on(&object.name), &VOXEL_COVERAGE)?;
        Some((object.name.clone(), PairedSample::new([pair]).differences()[0]))
    };
    let mut by_object: Vec<(String, f64)> = a.study.objects.iter().filter_map(coverage).collect();
    by_object.sort_by(|a, b| b.1.total_cmp(&a.1));
    let listed = |(name, difference): &(String, f64)| (name.clone(), 100.0 * difference);
    VariantComparison {
        variant_a: a.variant.name.clone(),
        variant_b: b.variant.name.clone(),
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
