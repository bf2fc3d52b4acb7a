use super::*;
use crate::synthetic::{campaign, done_mut, steps_mut, stored};
use crate::{RunRecord, RunResult};

/// The comparison of two folders with these records.
fn compare(a: &[RunRecord], b: &[RunRecord]) -> Comparison {
    let [a, b] = [("a", a), ("b", b)].map(|(name, runs)| stored(name, runs));
    super::compare(&a.1, &b.1).unwrap()
}

/// Four variants, a failed run, a run with two seeds, one that stopped early.
fn varied() -> Vec<RunRecord> {
    let mut runs = campaign(&["random", "rse", "apora", "max-flow"], 6);
    runs[3].result = RunResult::Failed("the box needs 9000 MB | more than 4096".to_owned());
    steps_mut(&mut runs[8]).truncate(6);
    let mut again = runs[9].clone();
    again.seed = 1;
    for coverage in steps_mut(&mut again).iter_mut().filter_map(|step| step.voxel_coverage.as_mut()) {
        *coverage *= 0.97;
    }
    runs.push(again);
    runs
}

/// B with this change to its runs.
fn changed(a: &[RunRecord], change: impl Fn(&mut RunRecord)) -> Vec<RunRecord> {
    let mut b = a.to_vec();
    b.iter_mut().for_each(change);
    b
}

#[test]
fn equal_campaigns_are_identical_apart_from_times() {
    let a = varied();
    let b = changed(&a, |run| {
        if run.done().is_some() {
            done_mut(run).extra_memory_mb = None;
            steps_mut(run).iter_mut().for_each(|step| step.plan_time_ms *= 3.0);
        }
    });
    let comparison = compare(&a, &b);
    assert!(comparison.is_identical() && comparison.n_pairs == a.len());
    assert!(comparison.variants.iter().all(|v| v.better.is_empty() && v.worse.is_empty()));
    let times = comparison.variants.iter().map(|variant| variant.measures.last().unwrap());
    assert!(times.clone().count() == 4 && times.clone().all(|time| time.is_ratio));
    assert!(
        times.clone().all(|time| (time.difference - 3.0).abs() < 1e-9 && time.b_is_better == Some(false))
    );
}

#[test]
fn differences_are_found_and_judged() {
    let a = campaign(&["apora", "max-flow"], 6);
    let mut b = changed(&a, |run| {
        let shift = if run.object == "mug" { -0.02 } else { 0.01 };
        let is_apora = run.variant == "apora";
        for step in steps_mut(run) {
            if is_apora {
                step.path_length_m -= 0.5;
            } else {
                step.voxel_coverage = step.voxel_coverage.map(|coverage| coverage + shift);
            }
        }
    });
    b.remove(6);
    b[0].result = RunResult::Failed("x".to_owned());
    let comparison = compare(&a, &b);
    assert!(!comparison.pairs_are_identical);
    assert_eq!((comparison.only_in_a.len(), comparison.only_in_b.len()), (1, 0));
    assert_eq!((comparison.failed_only_in_a.len(), comparison.failed_only_in_b.len()), (0, 1));
    let [apora, max_flow] = &comparison.variants[..] else { panic!() };
    assert_eq!((apora.n_objects, max_flow.n_objects), (5, 5));
    let path = apora.measures.iter().find(|m| m.name == "path length, m").unwrap();
    assert!(
        (path.difference + 0.5).abs() < 1e-9 && path.is_more_than_noise && path.b_is_better == Some(true)
    );
    let coverage = &max_flow.measures[0];
    assert!((coverage.difference - 0.4).abs() < 1e-9 && !coverage.is_more_than_noise);
    assert_eq!((max_flow.better.len(), max_flow.worse.len()), (4, 1));
    assert_eq!(max_flow.worse[0].0, "mug");
    let json = serde_json::to_value(&comparison).unwrap();
    assert_eq!(json["variants"][1]["measures"][0]["name"], "voxel coverage, %");
}

#[test]
fn two_single_variants_are_compared_with_each_other() {
    let (a, b) = (campaign(&["apora"], 4), campaign(&["rse"], 6));
    let comparison = compare(&a, &b);
    assert_eq!((comparison.n_pairs, comparison.only_in_b.len()), (4, 2));
    assert!(comparison.only_in_b[0].starts_with("rse on "), "{:?}", comparison.only_in_b);
    let [variant] = &comparison.variants[..] else { panic!() };
    assert_eq!((&variant.variant_a[..], &variant.variant_b[..], variant.n_objects), ("apora", "rse", 4));
    let comparison = compare(&campaign(&["x", "y"], 1), &b);
    assert_eq!((comparison.n_pairs, comparison.variants.len()), (0, 0));
}

#[test]
fn data_sets_may_have_other_names() {
    let a = campaign(&["a"], 6);
    // In a different order by data set.
    let b = changed(&a, |run| {
        run.data_set = if run.data_set == "lm" { "zzz".to_owned() } else { "a".to_owned() }
    });
    let comparison = compare(&a, &b);
    assert!(comparison.is_identical() && comparison.variants[0].n_objects == 6);
    assert!(comparison.variants[0].better.is_empty() && comparison.variants[0].worse.is_empty());
}

#[test]
fn a_run_without_baselines_has_no_reachable_coverage() {
    let mut runs = campaign(&["a"], 1);
    let record = &mut done_mut(&mut runs[0]).record;
    (record.random_curve, record.skill) = (None, None);
    record.steps.iter_mut().for_each(|step| step.reachable_coverage = None);
    let study = Study::new(&runs);
    let mean = |measure: &Measure| study.variants[0].mean(measure);
    assert_eq!(mean(&measure::REACHABLE_COVERAGE).or(mean(&measure::VIEWS_TO_95)), None);
    assert_eq!(mean(&measure::COVERAGE_BEYOND_RANDOM).or(mean(&measure::SKILL)), None);
    assert!(mean(&measure::VOXEL_COVERAGE).is_some() && mean(&measure::RUNNING_TIME).is_some());
}
