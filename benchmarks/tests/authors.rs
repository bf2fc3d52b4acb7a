//! The profile `authors-code` against the authors' recorded run and what was measured of their program.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview_benchmarks::authors::Slips;
use nextview_benchmarks::authors::map::Knowledge;
use nextview_benchmarks::authors::recording::{N_SCANS, RecordedRun};
use nextview_benchmarks::authors::reference::{CURVES, FIRST_PLAN, FIXED_ORDER, ORDER_LIKE_FIXED};
use nextview_benchmarks::authors::run::{ChoiceRule, ScannedObject, StepResult};
use nextview_checks::data;

/// The recorded run; none if the reference data is not there.
fn scene(test: &str) -> Option<ScannedObject> {
    let folder = data(test, "authors")?;
    Some(ScannedObject::new(RecordedRun::read(&folder).unwrap()).unwrap())
}

fn largest_difference(steps: &[StepResult], curve: &[f64; N_SCANS]) -> f64 {
    assert_eq!(steps.len(), N_SCANS);
    steps.iter().zip(curve).map(|(step, c)| (step.coverage - c).abs()).fold(0.0, f64::max)
}

/// The sensor's roll is known to a degree, so that voxels at outlines differ.
#[test]
fn recorded_views_give_the_recorded_maps() {
    let Some(scene) = scene("recorded_views_give_the_recorded_maps") else { return };
    let steps = scene.run(Slips::AUTHORS_CODE, ChoiceRule::Recorded).unwrap();
    for (step, recorded) in steps.iter().zip(&scene.recording.maps) {
        let n_different = step.log_odds.iter().zip(recorded).filter(|(a, b)| a != b).count();
        let [ours, theirs] =
            [&step.log_odds, recorded].map(|map| Knowledge::new(map, &scene.recording, true).unwrap());
        let n_occupied = [&ours, &theirs].map(|map| map.n_occupied());
        println!("view {}: {n_different} voxels differ, occupied {n_occupied:?}", step.view);
        assert!(n_different <= 90, "of 8000");
        assert!(n_occupied[0].abs_diff(n_occupied[1]) <= 6);
        assert!((ours.entropy() - theirs.entropy()).abs() < 2.0);
    }
    assert!(largest_difference(&steps, &CURVES[0].1) < 0.011);
}

#[test]
fn a_fitted_order_gives_the_curve_of_their_program() {
    let Some(scene) = scene("a_fitted_order_gives_the_curve_of_their_program") else { return };
    let steps = scene.run(Slips::AUTHORS_CODE, ChoiceRule::max_flow(ORDER_LIKE_FIXED)).unwrap();
    let difference = largest_difference(&steps, &FIXED_ORDER);
    println!("largest difference {difference:.4}");
    assert!(difference <= 0.02);
}

#[test]
fn the_first_plan_has_their_rays_and_their_flow() {
    let Some(scene) = scene("the_first_plan_has_their_rays_and_their_flow") else { return };
    let survey = scene.survey(Slips::AUTHORS_CODE).unwrap();
    let ours = [
        survey.n_rays as f64,
        survey.rays_per_view,
        survey.n_views_without as f64,
        survey.n_voxels as f64,
        survey.n_edges as f64,
        survey.quality,
    ];
    println!("{ours:?}, theirs {FIRST_PLAN:?}");
    for (ours, theirs) in ours.into_iter().zip(FIRST_PLAN) {
        assert!((ours / theirs - 1.0).abs() < 0.06, "{ours}, theirs {theirs}");
    }
}
