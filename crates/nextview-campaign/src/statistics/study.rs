use super::measure::VOXEL_COVERAGE;
use super::{Curve, Measure, MeasuredRun, PairedObject, PairedSample, Sample, mean};
use crate::RunRecord;
use nextview_scan::{PlannerChoice, ScanConfig};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// The runs of a campaign by variant and object. Each number of an object is the mean over its runs.
#[derive(Clone, Debug)]
pub struct Study {
    /// Number of runs, including failed ones.
    pub n_runs: usize,
    /// Objects by data set, then by name.
    pub objects: Vec<StudyObject>,
    /// Variants by descending mean voxel coverage.
    pub variants: Vec<StudyVariant>,
}

/// An object of the campaign.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct StudyObject {
    /// Name of the folder of its file, or `builtin`.
    pub data_set: String,
    /// Name of the object.
    pub name: String,
}

/// A planner with its parameters.
#[derive(Clone, Debug)]
pub struct StudyVariant {
    /// Label.
    pub name: String,
    /// The planner.
    pub planner: PlannerChoice,
    /// The configuration of any of its runs.
    pub example: ScanConfig,
    /// The measured runs on each object of the study.
    pub runs: Vec<Vec<MeasuredRun>>,
}

/// A study in progress: takes record after record and stores their data for statistics.
#[derive(Clone, Debug, Default)]
pub struct StudyBuilder {
    n_runs: usize,
    /// Objects with their numbers, in order of arrival.
    objects: BTreeMap<StudyObject, usize>,
    /// Runs by the number of the object.
    variants: BTreeMap<String, StudyVariant>,
}

impl StudyBuilder {
    /// Adds a run.
    pub fn add(&mut self, run: &RunRecord) {
        self.n_runs += 1;
        let n_objects = self.objects.len();
        let object = *self.objects.entry(StudyObject::of(run)).or_insert(n_objects);
        let variant = self.variants.entry(run.variant.clone()).or_insert_with(|| StudyVariant {
            name: run.variant.clone(),
            planner: run.config.planner.clone(),
            example: run.config.clone(),
            runs: Vec::new(),
        });
        variant.runs.resize_with(variant.runs.len().max(object + 1), Vec::new);
        variant.runs[object].extend(MeasuredRun::of(run));
    }

    /// Builds the study of all runs; the runs of an object stay in order of arrival.
    pub fn build(self) -> Study {
        let order = |mut variant: StudyVariant| {
            variant.runs.resize_with(self.objects.len(), Vec::new);
            variant.runs = self.objects.values().map(|&i| std::mem::take(&mut variant.runs[i])).collect();
            variant
        };
        let mut variants: Vec<StudyVariant> = self.variants.into_values().map(order).collect();
        // A stable sort: equal variants stay in the order of their names.
        variants.sort_by_cached_key(|variant| {
            let coverage = variant.mean(&VOXEL_COVERAGE).unwrap_or(-1.0);
            Reverse((coverage * 1e9) as i64)
        });
        Study { n_runs: self.n_runs, objects: self.objects.into_keys().collect(), variants }
    }
}

impl Study {
    /// Creates a study of these runs; the runs of each object stay in this order.
    pub fn new<'a>(runs: impl IntoIterator<Item = &'a RunRecord>) -> Self {
        let mut builder = StudyBuilder::default();
        runs.into_iter().for_each(|run| builder.add(run));
        builder.build()
    }
}

impl StudyObject {
    /// Returns the object of a run.
    pub fn of(run: &RunRecord) -> Self {
        Self { data_set: run.data_set.clone(), name: run.object.clone() }
    }
}

impl StudyVariant {
    /// Returns the measure for each object of the study; `None` if no run measured it.
    pub fn by_object(&self, measure: &Measure) -> Vec<Option<f64>> {
        let of_object =
            |runs: &Vec<MeasuredRun>| mean(&runs.iter().filter_map(measure.of).collect::<Vec<_>>());
        self.runs.iter().map(of_object).collect()
    }

    /// Returns the measure of all runs that have it, by object; objects without such runs are left out.
    pub fn sample(&self, measure: &Measure) -> Sample {
        self.sample_by(measure.of)
    }

    /// Returns the value that `of` gives for each run, by object; objects without any value are left out.
    pub fn sample_by(&self, of: impl Fn(&MeasuredRun) -> Option<f64>) -> Sample {
        Sample::new(self.runs.iter().map(|runs| runs.iter().filter_map(&of).collect()))
    }

    /// Returns the mean over objects.
    pub fn mean(&self, measure: &Measure) -> Option<f64> {
        self.sample(measure).mean()
    }

    /// Pairs this variant as A with another one of the same study as B, on the objects where both have the
    /// measure.
    pub fn beside(&self, other: &StudyVariant, measure: &Measure) -> PairedSample {
        let pairs = self.runs.iter().zip(&other.runs);
        PairedSample::new(pairs.filter_map(|(a, b)| paired(a, b, measure)))
    }

    /// Returns the worst of the objects that have the measure, by its number, with the value; the first on
    /// ties.
    pub fn worst(&self, measure: &Measure) -> Option<(usize, f64)> {
        let values = self.by_object(measure).into_iter().enumerate();
        values.filter_map(|(i, value)| Some((i, value?))).min_by(|a, b| measure.better.order(a.1, b.1))
    }

    /// Returns the number of objects with a measured run.
    pub fn n_objects(&self) -> usize {
        self.runs.iter().filter(|runs| !runs.is_empty()).count()
    }

    /// Returns all measured runs.
    pub fn measured(&self) -> impl Iterator<Item = &MeasuredRun> {
        self.runs.iter().flatten()
    }

    /// Returns the values after each view, up to the last view that all runs could take.
    pub fn curve(&self, of: Curve) -> Vec<Sample> {
        self.curve_by(|run| run.curve(of))
    }

    /// Returns the values of any curve of a run after each view.
    pub fn curve_by(&self, of: impl Fn(&MeasuredRun) -> Option<Vec<f64>>) -> Vec<Sample> {
        let curves_of = |runs: &Vec<MeasuredRun>| runs.iter().filter_map(&of).collect();
        let objects: Vec<Vec<Vec<f64>>> = self.runs.iter().map(curves_of).collect();
        let n_views = objects.iter().flatten().map(Vec::len).min().unwrap_or(0);
        let after = |view: usize| {
            Sample::new(objects.iter().map(|curves| curves.iter().map(|curve| curve[view]).collect()))
        };
        (0..n_views).map(after).collect()
    }
}

/// The measure of an object's runs, for A and for B; `None` if either lacks it.
fn paired(a: &[MeasuredRun], b: &[MeasuredRun], measure: &Measure) -> Option<PairedObject> {
    PairedObject::new(keyed(a, measure), keyed(b, measure))
}

/// The measure of each run that has it, with the run's draws.
fn keyed(runs: &[MeasuredRun], measure: &Measure) -> Vec<((u64, u64, usize), f64)> {
    runs.iter().filter_map(|run| Some((run.draw, (measure.of)(run)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{campaign, steps_mut};

    #[test]
    fn runs_of_one_object_are_averaged_first() {
        let mut runs = campaign(&["a"], 2);
        let mut again = runs[0].clone();
        again.seed = 1;
        let last = steps_mut(&mut again).last_mut().unwrap();
        last.voxel_coverage = last.voxel_coverage.map(|coverage| coverage - 0.2);
        runs.push(again);
        let study = Study::new(&runs);
        let coverage = |run: &RunRecord| (VOXEL_COVERAGE.of)(&MeasuredRun::of(run).unwrap()).unwrap();
        let object = study.objects.iter().position(|o| *o == StudyObject::of(&runs[0])).unwrap();
        let all = study.variants[0].by_object(&VOXEL_COVERAGE);
        assert!((all[object].unwrap() - (coverage(&runs[0]) - 0.1)).abs() < 1e-12);
        assert_eq!(all[1 - object], Some(coverage(&runs[1])));
    }

    #[test]
    fn views_to_a_share_are_those_of_the_first_view_that_reaches_it() {
        let mut runs = campaign(&["a"], 1);
        let curve = [0.2, 0.6, 0.9, 0.7, 0.96];
        let steps = steps_mut(&mut runs[0]);
        steps.truncate(curve.len());
        steps.iter_mut().zip(curve).for_each(|(step, share)| step.reachable_coverage = Some(share));
        let study = Study::new(&runs);
        let run = study.variants[0].measured().next().unwrap();
        let views = [0.1, 0.2, 0.5, 0.9, 0.95, 0.97].map(|share| run.views_to(share).unwrap());
        assert_eq!(views, [1.0, 1.0, 2.0, 3.0, 5.0, 11.0]);
        assert!(run.reaches(0.96) && !run.reaches(0.97));
    }

    #[test]
    fn a_run_that_stopped_early_keeps_its_last_value() {
        let mut runs = campaign(&["a"], 1);
        steps_mut(&mut runs[0]).truncate(2);
        let study = Study::new(&runs);
        let curve = study.variants[0].curve(Curve::ReachableCoverage);
        assert_eq!(Some(curve.len()), runs[0].config.views);
        assert_eq!(curve[1], curve[9]);
        let run = study.variants[0].measured().next().unwrap();
        assert_eq!((run.views_to(0.9), run.reaches(0.9)), (Some(11.0), false));
    }
}
