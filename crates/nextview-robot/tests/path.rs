//! Paths and trajectories of a whole arm.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod cell;

use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview_robot::collision::Checker;
use nextview_robot::path::{JointTrajectory, NoPath, line_contact, plan_path, plan_path_to_any};

/// Random pairs; `NEXTVIEW_JOINT_PATHS` is how many (30 if it is not set).
fn n_paths() -> usize {
    std::env::var("NEXTVIEW_JOINT_PATHS").map_or(30, |n| n.parse().unwrap())
}

/// The least margin over densely sampled values between two.
fn sampled_distance(checker: &Checker, from: &[f64], to: &[f64]) -> f64 {
    let longest = from.iter().zip(to).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
    let n = (longest / 0.005).ceil().max(1.0);
    let at =
        |i: usize| -> Vec<f64> { from.iter().zip(to).map(|(a, b)| a + i as f64 / n * (b - a)).collect() };
    (0..=n as usize).map(|i| checker.distance(&at(i))).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_free_line_is_free_at_dense_samples_and_others_are_not_refused_without_reason() {
    let checker = cell::checker();
    let mut random = Random::new(4, 0);
    let cancel = Cancel::default();
    let (mut n_free, mut n_blocked) = (0, 0);
    for _ in 0..60 {
        let from = cell::free_values(&checker, &mut random);
        let to: Vec<f64> = from.iter().map(|value| value + random.range(-0.6, 0.6)).collect();
        let least = sampled_distance(&checker, &from, &to);
        match line_contact(&checker, &from, &to, &cancel).unwrap() {
            None => {
                n_free += 1;
                assert!(least >= Checker::SELF_CLEARANCE - Checker::SLACK, "{least}");
            }
            Some(contact) => {
                n_blocked += 1;
                // Between two samples, nothing moves by a centimetre.
                assert!(least < cell::CLEARANCE + 0.01, "{least}: {contact}");
            }
        }
    }
    assert!(n_free > 10 && n_blocked > 10, "{n_free} free, {n_blocked} blocked");
}

#[test]
fn paths_are_free_and_trajectories_keep_the_limits() {
    let checker = cell::checker();
    let mut random = Random::new(6, 0);
    let cancel = Cancel::default();
    let (mut n_found, mut n_bent) = (0, 0);
    for seed in 0..n_paths() as u64 {
        let from = cell::free_values(&checker, &mut random);
        let to = cell::free_values(&checker, &mut random);
        let path = match plan_path(&checker, &from, &to, seed, 2000, &cancel) {
            Ok(path) => path,
            Err(NoPath::NotFound { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        n_found += 1;
        n_bent += usize::from(path.corners().len() > 2);
        assert_eq!((path.corners().first(), path.corners().last()), (Some(&from), Some(&to)));
        for leg in path.corners().windows(2).take(3) {
            assert!(sampled_distance(&checker, &leg[0], &leg[1]) >= Checker::SELF_CLEARANCE - Checker::SLACK);
        }
        check_times(&JointTrajectory::along(&path, checker.arm()), &checker);
        if seed < 3 {
            assert_eq!(plan_path(&checker, &from, &to, seed, 2000, &cancel), Ok(path), "same seed");
        }
    }
    assert!(10 * n_found >= 9 * n_paths() && n_bent > 0, "{n_found} found, {n_bent} bent");
}

/// Differences of the trajectory keep the limits of speed and acceleration.
fn check_times(trajectory: &JointTrajectory, checker: &Checker) {
    let arm = checker.arm();
    assert_eq!(trajectory.names.len(), 6);
    assert_eq!(trajectory.points[0].0, 0.0);
    assert_eq!(trajectory.points.last().unwrap().0, trajectory.duration());
    let mut before: Option<(f64, Vec<f64>)> = None;
    for pair in trajectory.points.windows(2) {
        let step = pair[1].0 - pair[0].0;
        assert!(step > 0.0 && step <= JointTrajectory::LONGEST_STEP * (1.0 + 1e-9), "{step} s");
        assert!(arm.is_within_limits(&pair[1].1));
        let speeds: Vec<f64> = pair[0].1.iter().zip(&pair[1].1).map(|(a, b)| (b - a) / step).collect();
        let (step_before, speeds_before) = before.unwrap_or((0.0, vec![0.0; 6]));
        for i in 0..6 {
            let limits = arm.joints[i].limits;
            assert!(speeds[i].abs() <= limits.velocity * (1.0 + 1e-9));
            // Mean speeds are those in the middle of steps.
            let change = (speeds[i] - speeds_before[i]).abs();
            let most = limits.acceleration * 0.5 * (step + step_before);
            assert!(change <= most * (1.0 + 1e-6) + 1e-9, "{change}, {most}");
        }
        before = Some((step, speeds));
    }
}

#[test]
fn of_several_goals_a_straight_and_near_one_is_taken() {
    let checker = cell::checker();
    let cancel = Cancel::default();
    let from = vec![0.0, -1.57, 0.0, -1.57, 0.0, 0.0];
    let shifted = |by: f64| -> Vec<f64> { from.iter().map(|value| value + by).collect() };
    let in_table = vec![0.0, 0.3, 0.0, 0.0, 0.0, 0.0];
    let goals = [shifted(0.2), in_table.clone(), shifted(0.1)];
    let (goal, path) = plan_path_to_any(&checker, &from, &goals, 0, 100, &cancel).unwrap();
    assert_eq!((goal, path.corners().len()), (2, 2));
    let error = plan_path(&checker, &from, &in_table, 0, 100, &cancel).unwrap_err();
    assert!(error.to_string().starts_with("at the end, ") && error.to_string().ends_with("touches table"));
    let error = plan_path(&checker, &in_table, &from, 0, 100, &cancel).unwrap_err();
    assert!(error.to_string().starts_with("at the start, "), "{error}");
    let still = plan_path(&checker, &from, &from, 0, 100, &cancel).unwrap();
    assert_eq!(JointTrajectory::along(&still, checker.arm()).points, [(0.0, from.clone())]);
}

#[test]
fn what_is_no_path_is_said() {
    let checker = cell::checker();
    let cancel = Cancel::default();
    let from = vec![0.0, -1.57, 0.0, -1.57, 0.0, 0.0];
    let error = plan_path(&checker, &[f64::NAN; 6], &[0.0; 5], 0, 100, &cancel).unwrap_err().to_string();
    assert!(error.contains("start: joint 1 is NaN, expected -6.28"), "{error}");
    assert!(error.ends_with("goal 0 has 5 values, expected 6"), "{error}");
    assert!(plan_path_to_any(&checker, &from, &[], 0, 100, &cancel).is_err());
    cancel.cancel();
    let to = vec![1.0, -1.57, 0.0, -1.57, 0.0, 0.0];
    let cancelled = plan_path(&checker, &from, &to, 0, 100, &cancel);
    assert_eq!(cancelled, Err(NoPath::Cancelled(nextview::Cancelled)));
}
