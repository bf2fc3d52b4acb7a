use super::measure::VOXEL_COVERAGE;
use super::{Curve, Measure, MeasuredRun, PairedObject, PairedSample, Sample, mean};
use crate::RunRecord;
use nextview_scan::PlannerChoice;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// The runs of a campaign by variant and object. Every number of an object is the mean over its runs.
#[derive(Clone, Debug)]
pub struct Study<'a> {
    /// All runs, failed ones included.
    pub runs: Vec<&'a RunRecord>,
    /// By data set, then by name.
    pub objects: Vec<StudyObject<'a>>,
    /// From the largest mean voxel coverage to the smallest.
    pub variants: Vec<StudyVariant<'a>>,
}

/// An object of the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct StudyObject<'a> {
    /// Name of the folder that its file is in, or `builtin`.
    pub data_set: &'a str,
    /// Name of the object.
    pub name: &'a str,
}

/// A planner with its parameters.
#[derive(Clone, Debug)]
pub struct StudyVariant<'a> {
    /// Label.
    pub name: &'a str,
    /// The planner.
    pub planner: &'a PlannerChoice,
    /// Any of its records, for the configuration.
    pub example: &'a RunRecord,
    /// The measured runs on each object of the study.
    pub runs: Vec<Vec<MeasuredRun<'a>>>,
}

impl<'a> Study<'a> {
    /// These runs, the runs of an object in this order.
    pub fn new(runs: impl IntoIterator<Item = &'a RunRecord>) -> Self {
        let runs: Vec<&RunRecord> = runs.into_iter().collect();
        let mut objects: Vec<StudyObject<'_>> = runs.iter().map(|run| StudyObject::of(run)).collect();
        objects.sort();
        objects.dedup();
        let mut by_variant = BTreeMap::<&str, Vec<&RunRecord>>::new();
        runs.iter().for_each(|run| by_variant.entry(&run.variant).or_default().push(run));
        let mut variants: Vec<StudyVariant<'_>> =
            by_variant.into_iter().map(|(name, runs)| StudyVariant::new(name, &runs, &objects)).collect();
        // A stable sort: equal ones stay in the order of their names.
        variants.sort_by_cached_key(|variant| {
            let coverage = variant.mean(&VOXEL_COVERAGE).unwrap_or(-1.0);
            Reverse((coverage * 1e9) as i64)
        });
        Self { runs, objects, variants }
    }
}

impl<'a> StudyObject<'a> {
    /// The object of a run.
    pub fn of(run: &'a RunRecord) -> Self {
        Self { data_set: &run.data_set, name: &run.object }
    }
}

impl<'a> StudyVariant<'a> {
    fn new(name: &'a str, runs: &[&'a RunRecord], objects: &[StudyObject<'_>]) -> Self {
        let of_object = |object: &StudyObject<'_>| {
            runs.iter()
                .filter(|run| StudyObject::of(run) == *object)
                .filter_map(|run| MeasuredRun::of(run))
                .collect()
        };
        let example = runs[0];
        Self {
            name,
            planner: &example.config.planner,
            example,
            runs: objects.iter().map(of_object).collect(),
        }
    }

    /// The measure for each object of the study; none where no run measured it.
    pub fn by_object(&self, measure: &Measure) -> Vec<Option<f64>> {
        let of_object =
            |runs: &Vec<MeasuredRun<'_>>| mean(&runs.iter().filter_map(measure.of).collect::<Vec<_>>());
        self.runs.iter().map(of_object).collect()
    }

    /// The measure of all runs of the objects that have it.
    pub fn sample(&self, measure: &Measure) -> Sample {
        self.sample_by(measure.of)
    }

    /// The same of any number of a run.
    pub fn sample_by(&self, of: impl Fn(&MeasuredRun<'a>) -> Option<f64>) -> Sample {
        Sample::new(self.runs.iter().map(|runs| runs.iter().filter_map(&of).collect()))
    }

    /// Mean over objects.
    pub fn mean(&self, measure: &Measure) -> Option<f64> {
        self.sample(measure).mean()
    }

    /// This variant as A and another one of the same study as B, on the objects where both have the measure.
    pub fn beside(&self, other: &StudyVariant<'_>, measure: &Measure) -> PairedSample {
        let pairs = self.runs.iter().zip(&other.runs);
        PairedSample::new(pairs.filter_map(|(a, b)| paired(a, b, measure)))
    }

    /// The worst of the objects that have the measure, by its number, with the value; the first on ties.
    pub fn worst(&self, measure: &Measure) -> Option<(usize, f64)> {
        let values = self.by_object(measure).into_iter().enumerate();
        values.filter_map(|(i, value)| Some((i, value?))).min_by(|a, b| measure.better.order(a.1, b.1))
    }

    /// Number of objects with a measured run.
    pub fn n_objects(&self) -> usize {
        self.runs.iter().filter(|runs| !runs.is_empty()).count()
    }

    /// All measured runs.
    pub fn measured(&self) -> impl Iterator<Item = &MeasuredRun<'a>> {
        self.runs.iter().flatten()
    }

    /// The values after each view, up to the last view that all runs could take.
    pub fn curve(&self, of: Curve) -> Vec<Sample> {
        self.curve_by(|run| run.curve(of))
    }

    /// The same for any curve of a run.
    pub fn curve_by(&self, of: impl Fn(&MeasuredRun<'a>) -> Option<Vec<f64>>) -> Vec<Sample> {
        let curves_of = |runs: &Vec<MeasuredRun<'a>>| runs.iter().filter_map(&of).collect();
        let objects: Vec<Vec<Vec<f64>>> = self.runs.iter().map(curves_of).collect();
        let n_views = objects.iter().flatten().map(Vec::len).min().unwrap_or(0);
        let after = |view: usize| {
            Sample::new(objects.iter().map(|curves| curves.iter().map(|curve| curve[view]).collect()))
        };
        (0..n_views).map(after).collect()
    }
}

/// The measure of the runs of an object, for A and for B; none where either has none.
pub(super) fn paired(
    a: &[MeasuredRun<'_>],
    b: &[MeasuredRun<'_>],
    measure: &Measure,
) -> Option<PairedObject> {
    PairedObject::new(keyed(a, measure), keyed(b, measure))
}

/// The measure of each run that has it, with what the run was drawn by.
fn keyed(runs: &[MeasuredRun<'_>], measure: &Measure) -> Vec<((u64, u64, usize), f64)> {
    runs.iter().filter_map(|run| Some((run.draw, (measure.of)(run)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{campaign, steps_mut};

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
