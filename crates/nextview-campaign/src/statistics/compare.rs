use super::measure::{
    Better, Measure, PATH, PLAN_TIME, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, VOXEL_COVERAGE,
};
use super::{
    Comparison, Interval, MeasureComparison, MeasuredRun, PairedObject, PairedSample, StudyObject,
    VariantComparison, mean, percentile,
};
use crate::store::StoredRuns;
use crate::{RunId, RunRecord};
use nextview_scan::Fault;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Minimum difference in voxel coverage of listed objects.
const LISTED: f64 = 1e-3;

/// Maximum number of objects in a list.
const MAX_LISTED: usize = 10;

/// The compared measures. The last one, the time, is compared by ratios, all others by differences.
const MEASURES: [Measure; 6] = [VOXEL_COVERAGE, REACHABLE_COVERAGE, SKILL, VIEWS_TO_95, PATH, PLAN_TIME];
const TIME: usize = MEASURES.len() - 1;

/// Compares the common runs of campaigns A and B. Both are read once, in parallel.
pub fn compare(a: &StoredRuns, b: &StoredRuns) -> Result<Comparison, Fault> {
    let (variants, renamed) = variants(a, b);
    let mut found = CommonRuns::default();
    // Both are sorted by identity, even if B's only variant has another name.
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
    let compared = variants
        .iter()
        .filter_map(|(name_a, name_b)| Some(of_variant([name_a, name_b], found.variants.get(*name_a)?)));
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

/// The names of the compared variants: those with equal names, or the only one of A with the only one of B.
/// In the latter case the second value is the name in A.
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

/// The identity in A of a run of B.
fn id_in_a(run: &RunRecord, renamed: Option<&str>) -> RunId {
    let id = run.id();
    RunId { variant: renamed.map_or(id.variant, str::to_owned), ..id }
}

/// The runs found in both campaigns.
#[derive(Default)]
struct CommonRuns {
    /// For each variant, by its name in A.
    variants: BTreeMap<String, BTreeMap<StudyObject, ObjectRuns>>,
    n_pairs: usize,
    only_in_a: Vec<String>,
    only_in_b: Vec<String>,
    failed_only_in_a: Vec<String>,
    failed_only_in_b: Vec<String>,
    has_unequal_pair: bool,
}

impl CommonRuns {
    /// Adds the next run: of A, of B, or of both.
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
                let of_variant = self.variants.entry(a.variant.clone()).or_default();
                let runs = of_variant.entry(StudyObject::of(a)).or_default();
                runs.a.extend(ComparedRun::of(a));
                runs.b.extend(ComparedRun::of(b));
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

/// The compared numbers of a run: a small part of a report's data.
struct ComparedRun {
    /// The draws of the run: seed, set of candidates and first view.
    draw: (u64, u64, usize),
    values: [Option<f64>; MEASURES.len()],
}

impl ComparedRun {
    /// `None` if the run took no view.
    fn of(run: &RunRecord) -> Option<Self> {
        let run = MeasuredRun::of(run)?;
        Some(Self { draw: run.draw, values: MEASURES.map(|measure| (measure.of)(&run)) })
    }
}

/// The runs of both campaigns on an object.
#[derive(Default)]
struct ObjectRuns {
    a: Vec<ComparedRun>,
    b: Vec<ComparedRun>,
}

impl ObjectRuns {
    /// The measure with this number; `None` if A or B lacks it.
    fn paired(&self, measure: usize) -> Option<PairedObject> {
        let values = |runs: &[ComparedRun]| {
            runs.iter().filter_map(|run| Some((run.draw, run.values[measure]?))).collect()
        };
        PairedObject::new(values(&self.a), values(&self.b))
    }
}

fn of_variant([name_a, name_b]: [&str; 2], objects: &BTreeMap<StudyObject, ObjectRuns>) -> VariantComparison {
    let pairs = |measure| PairedSample::new(objects.values().filter_map(|runs| runs.paired(measure)));
    let mut measures: Vec<MeasureComparison> =
        (0..TIME).filter_map(|i| difference(&MEASURES[i], &pairs(i))).collect();
    measures.extend(ratio(&MEASURES[TIME], &pairs(TIME).positive()));
    let coverage = |(object, runs): (&StudyObject, &ObjectRuns)| {
        Some((object.name.clone(), PairedSample::new([runs.paired(0)?]).differences()[0]))
    };
    let mut by_object: Vec<(String, f64)> = objects.iter().filter_map(coverage).collect();
    by_object.sort_by(|a, b| b.1.total_cmp(&a.1));
    let listed = |(name, difference): &(String, f64)| (name.clone(), 100.0 * difference);
    VariantComparison {
        variant_a: name_a.to_owned(),
        variant_b: name_b.to_owned(),
        n_objects: objects.values().filter(|runs| !runs.a.is_empty()).count(),
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

/// For times: the ratio of the displayed means, and the median of the objects' ratios.
fn ratio(measure: &Measure, pairs: &PairedSample) -> Option<MeasureComparison> {
    let ratios: Vec<f64> = pairs.of_a().iter().zip(pairs.of_b()).map(|(a, b)| b / a).collect();
    let (ratios, interval) = ([pairs.ratio()?, percentile(&ratios, 0.5)?], pairs.ratio_interval());
    Some(MeasureComparison {
        is_more_than_noise: interval.is_some_and(|interval| interval.excludes(1.0)),
        is_ratio: true,
        ..of_measure(measure, pairs, ratios, 1.0, interval)?
    })
}

/// The comparison of these differences or ratios, mean and median; `equal` means no difference.
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
