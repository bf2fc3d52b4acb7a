//! A campaign by variant and object: every number of an object is the mean over its runs.

use super::campaign::Campaign;
use super::measure::{Curve, Done, Measure, VOXEL_COVERAGE};
use super::statistics::mean;
use crate::bench::RunRecord;
use crate::scan::PlannerName;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// The runs of a campaign in order.
#[derive(Debug)]
pub(crate) struct Study<'a> {
    pub campaign: &'a Campaign,
    /// By data set, then by name.
    pub objects: Vec<Object<'a>>,
    /// From the largest mean voxel coverage to the smallest.
    pub variants: Vec<Variant<'a>>,
}

/// An object of the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Object<'a> {
    pub data_set: &'a str,
    pub name: &'a str,
}

/// A planner with its parameters.
#[derive(Debug)]
pub(crate) struct Variant<'a> {
    pub name: &'a str,
    pub planner: PlannerName,
    /// Any of its records, for the configuration.
    pub example: &'a RunRecord,
    /// The runs on each object of the study that were not given up.
    pub runs: Vec<Vec<Done<'a>>>,
}

impl<'a> Study<'a> {
    pub fn new(campaign: &'a Campaign) -> Self {
        let mut objects: Vec<Object<'_>> = campaign.runs.iter().map(Object::of).collect();
        objects.sort();
        objects.dedup();
        let mut by_variant = BTreeMap::<&str, Vec<&RunRecord>>::new();
        campaign.runs.iter().for_each(|run| by_variant.entry(&run.variant).or_default().push(run));
        let mut variants: Vec<Variant<'_>> =
            by_variant.into_iter().map(|(name, runs)| Variant::new(name, &runs, &objects)).collect();
        // A stable sort: equal ones stay in the order of their names.
        variants.sort_by_cached_key(|variant| {
            let coverage = variant.mean(&VOXEL_COVERAGE).unwrap_or(-1.0);
            Reverse((coverage * 1e9) as i64)
        });
        Self { campaign, objects, variants }
    }
}

impl<'a> Object<'a> {
    /// The object of a run.
    pub fn of(run: &'a RunRecord) -> Self {
        Self { data_set: &run.data_set, name: &run.object }
    }
}

impl<'a> Variant<'a> {
    fn new(name: &'a str, runs: &[&'a RunRecord], objects: &[Object<'_>]) -> Self {
        let of_object = |object: &Object<'_>| {
            runs.iter().filter(|run| Object::of(run) == *object).filter_map(|run| Done::of(run)).collect()
        };
        let example = runs[0];
        Self { name, planner: example.config.planner, example, runs: objects.iter().map(of_object).collect() }
    }

    /// The measure for each object of the study; none where no run measured it.
    pub fn by_object(&self, measure: &Measure) -> Vec<Option<f64>> {
        let of_object = |runs: &Vec<Done<'_>>| mean(&runs.iter().filter_map(measure.of).collect::<Vec<_>>());
        self.runs.iter().map(of_object).collect()
    }

    /// The measure of the objects that have it.
    pub fn values(&self, measure: &Measure) -> Vec<f64> {
        self.by_object(measure).into_iter().flatten().collect()
    }

    /// Mean over objects.
    pub fn mean(&self, measure: &Measure) -> Option<f64> {
        mean(&self.values(measure))
    }

    /// The number of objects with a run that was not given up.
    pub fn n_objects(&self) -> usize {
        self.runs.iter().filter(|runs| !runs.is_empty()).count()
    }

    /// All runs that were not given up.
    pub fn done(&self) -> impl Iterator<Item = &Done<'a>> {
        self.runs.iter().flatten()
    }

    /// For each view, the values of all objects; up to the last view that all runs could take.
    pub fn curve(&self, of: Curve) -> Vec<Vec<f64>> {
        self.curve_by(|run| run.curve(of))
    }

    /// The same for any curve of a run.
    pub fn curve_by(&self, of: impl Fn(&Done<'a>) -> Option<Vec<f64>>) -> Vec<Vec<f64>> {
        let of_object = |runs: &Vec<Done<'a>>| {
            let curves: Vec<Vec<f64>> = runs.iter().filter_map(&of).collect();
            (!curves.is_empty()).then(|| transposed(&curves).iter().filter_map(|v| mean(v)).collect())
        };
        transposed(&self.runs.iter().filter_map(of_object).collect::<Vec<Vec<f64>>>())
    }
}

/// Curves to values by view, as far as all curves go.
fn transposed(curves: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n_views = curves.iter().map(Vec::len).min().unwrap_or(0);
    (0..n_views).map(|i| curves.iter().map(|curve| curve[i]).collect()).collect()
}

/// The differences of two measures, for the objects that have both.
pub(crate) fn differences(a: &[Option<f64>], b: &[Option<f64>]) -> Vec<f64> {
    a.iter().zip(b).filter_map(|(a, b)| Some((*a)? - (*b)?)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::made_up;
    use super::*;

    #[test]
    fn runs_of_one_object_are_averaged_first() {
        let mut campaign = made_up::campaign(&["a"], 2);
        let mut again = campaign.runs[0].clone();
        again.seed = 1;
        made_up::measures_mut(&mut again).steps.last_mut().unwrap().voxel_coverage -= 0.2;
        campaign.runs.push(again);
        let study = Study::new(&campaign);
        let coverage = |run: &RunRecord| (VOXEL_COVERAGE.of)(&Done::of(run).unwrap()).unwrap();
        let object = study.objects.iter().position(|o| *o == Object::of(&campaign.runs[0])).unwrap();
        let all = study.variants[0].by_object(&VOXEL_COVERAGE);
        assert!((all[object].unwrap() - (coverage(&campaign.runs[0]) - 0.1)).abs() < 1e-12);
        assert_eq!(all[1 - object], Some(coverage(&campaign.runs[1])));
    }

    #[test]
    fn a_run_that_stopped_early_keeps_its_last_value() {
        let mut campaign = made_up::campaign(&["a"], 1);
        made_up::measures_mut(&mut campaign.runs[0]).steps.truncate(2);
        let study = Study::new(&campaign);
        let curve = study.variants[0].curve(Curve::Seen);
        assert_eq!(curve.len(), campaign.runs[0].config.views);
        assert_eq!(curve[1], curve[9]);
        let run = study.variants[0].done().next().unwrap();
        assert_eq!((run.views_to(0.9), run.reaches(0.9)), (Some(11.0), false));
    }
}
