use super::axis::SixAxes;
use super::closed_form::ClosedForm;
use super::{numeric, redundant};
use crate::{Arm, Joint, JointKind, JointLimits, Link};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const SIX_AXES: [&str; 5] = ["ur3e", "ur5e", "ur10e", "kr6_r900", "lr_mate_200id"];

fn n_poses(default: usize) -> usize {
    std::env::var("NEXTVIEW_IK_POSES").map_or(default, |n| n.parse().unwrap())
}

fn random_values(arm: &Arm, random: &mut Random) -> Vec<f64> {
    arm.joints.iter().map(|joint| random.range(joint.limits.lower, joint.limits.upper)).collect()
}

fn assert_reaches(arm: &Arm, values: &[f64], pose: &Pose) {
    let reached = arm.forward(values);
    assert!(reached.translation().distance(pose.translation()) <= 1e-6, "{values:?}");
    let turn = reached.rotation().conjugate() * pose.rotation();
    assert!(2.0 * turn.xyz().length() <= 1e-6, "{values:?}");
    assert!(arm.is_within_limits(values), "{values:?}");
}

fn is_near(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
}

/// Outcomes for the poses of random joint values.
#[derive(Debug, Default)]
struct Tally {
    n_poses: usize,
    n_solved: usize,
    n_found_again: usize,
    n_solutions: usize,
    seconds: f64,
}

impl Tally {
    fn of(arm: &Arm, n_poses: usize, seed: u64) -> Self {
        let mut random = Random::new(seed, 0);
        let mut tally = Self { n_poses, ..Self::default() };
        for _ in 0..n_poses {
            let values = random_values(arm, &mut random);
            let pose = arm.forward(&values);
            let start = std::time::Instant::now();
            let solutions = arm.inverse(&pose);
            tally.seconds += start.elapsed().as_secs_f64();
            tally.n_solved += usize::from(!solutions.is_empty());
            tally.n_solutions += solutions.len();
            solutions.iter().for_each(|solution| assert_reaches(arm, solution, &pose));
            assert!(solutions.is_sorted_by(|a, b| a < b), "in lexicographic order, none twice");
            // Close to a singular pose, rounding of the pose moves the joints further.
            tally.n_found_again +=
                usize::from(solutions.iter().any(|solution| is_near(solution, &values, 1e-5)));
        }
        tally
    }

    fn share(&self, n: usize) -> f64 {
        n as f64 / self.n_poses as f64
    }
}

/// `NEXTVIEW_IK_POSES` is the number of poses (2000 by default), spread over the arms. All are solved, and
/// their original joint values are found again: an independent measure of completeness.
#[test]
fn arms_of_six_axes_are_solved_completely() {
    for (seed, name) in SIX_AXES.into_iter().enumerate() {
        let arm = Arm::preset(name).unwrap();
        let tally = Tally::of(&arm, n_poses(2000).div_ceil(SIX_AXES.len()), seed as u64);
        println!("{name}: {tally:?}");
        assert!(tally.share(tally.n_solved) >= 0.999, "{name}: {tally:?}");
        assert!(tally.share(tally.n_found_again) >= 0.999, "{name}: {tally:?}");
    }
}

/// One pose of the seven-axis arm per fifty of the others: each takes as long as 64.
#[test]
fn an_arm_of_seven_axes_is_solved() {
    let arm = Arm::preset("panda").unwrap();
    let tally = Tally::of(&arm, n_poses(2000).div_ceil(50), 9);
    println!("panda: {tally:?}");
    assert!(tally.share(tally.n_solved) >= 0.999, "{tally:?}");
}

/// The slow twin: closed forms find every solution found by descent from random starts.
#[test]
fn closed_forms_miss_nothing_that_descent_finds() {
    let mut random = Random::new(3, 0);
    for name in SIX_AXES {
        let arm = Arm::preset(name).unwrap();
        let mut n_compared = 0;
        for _ in 0..10 {
            let pose = arm.forward(&random_values(&arm, &mut random));
            let solutions = arm.inverse(&pose);
            for values in numeric::search(&arm, &pose, None) {
                assert!(solutions.iter().any(|solution| is_near(solution, &values, 1e-4)), "{values:?}");
                n_compared += 1;
            }
        }
        assert!(n_compared > 100, "{name}: {n_compared}");
    }
}

/// An arm with slightly misaligned joints, as in a manufacturer's calibration.
fn calibrated(arm: &Arm, random: &mut Random) -> Arm {
    let mut arm = arm.clone();
    for joint in &mut arm.joints {
        let turn = DQuat::from_scaled_axis(1e-3 * random.in_cube());
        let error = Pose::new(turn, 5e-4 * random.in_cube()).unwrap();
        joint.parent_from_joint = joint.parent_from_joint * error;
    }
    arm
}

#[test]
fn calibrated_arms_are_solved() {
    let mut random = Random::new(5, 0);
    for name in SIX_AXES {
        let arm = calibrated(&Arm::preset(name).unwrap(), &mut random);
        assert!(ClosedForm::of(&SixAxes::of(&arm, None).unwrap()).is_some(), "{name}");
        let tally = Tally::of(&arm, n_poses(1500).div_ceil(SIX_AXES.len()), 1);
        println!("{name}: {tally:?}");
        assert!(tally.share(tally.n_solved) >= 0.99, "{name}: {tally:?}");
        assert!(tally.share(tally.n_found_again) >= 0.97, "{name}: {tally:?}");
    }
}

#[test]
fn singular_poses_have_solutions() {
    let cases: [(&str, &[f64]); 8] = [
        ("ur5e", &[0.0; 6]),
        ("ur5e", &[0.4, -1.0, 1.2, 0.3, 0.0, 0.7]),
        ("ur5e", &[0.4, -1.0, 1.2, 0.3, PI, 0.7]),
        ("ur10e", &[0.4, -1.0, 0.0, 0.3, 1.0, 0.7]),
        ("kr6_r900", &[0.0; 6]),
        ("kr6_r900", &[0.5, -1.0, 1.0, 0.4, 0.0, 0.3]),
        ("lr_mate_200id", &[0.0; 6]),
        ("panda", &[0.0, 0.0, 0.0, -FRAC_PI_2, 0.0, FRAC_PI_2, 0.0]),
    ];
    for (name, values) in cases {
        let arm = Arm::preset(name).unwrap();
        let pose = arm.forward(values);
        let solutions = arm.inverse_near(&pose, values);
        solutions.iter().for_each(|solution| assert_reaches(&arm, solution, &pose));
        let nearest = solutions.first().unwrap_or_else(|| panic!("{name} {values:?}"));
        assert!(is_near(nearest, values, 1e-3), "{name} {values:?}: {nearest:?}");
        assert!(!arm.inverse(&pose).is_empty());
    }
}

/// The wrist of a KUKA above its first axis, which is then arbitrary.
#[test]
fn a_first_axis_without_influence_takes_any_value() {
    let arm = Arm::preset("kr6_r900").unwrap();
    // By bisection over the third joint.
    let wrist_x = |third: f64| arm.link_poses(&[0.0, -1.8, third, 0.0, 0.3, 0.0])[5].translation().x;
    let (mut low, mut high) = (0.0, 2.5);
    let sign = wrist_x(low).signum();
    assert_ne!(sign, wrist_x(high).signum());
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if wrist_x(middle).signum() == sign { low = middle } else { high = middle }
    }
    let pose = arm.forward(&[0.7, -1.8, low, 0.2, 0.3, 0.4]);
    let solutions = arm.inverse(&pose);
    solutions.iter().for_each(|solution| assert_reaches(&arm, solution, &pose));
    let mut firsts: Vec<i64> = solutions.iter().map(|values| (values[0] * 1e3).round() as i64).collect();
    firsts.dedup();
    assert!(firsts.len() >= 6, "{firsts:?}");
}

#[test]
fn turns_within_the_limits_are_solutions_of_their_own() {
    let arm = Arm::preset("ur5e").unwrap();
    let values = [0.3, -1.2, 1.4, -0.6, 1.1, 0.5];
    let solutions = arm.inverse(&arm.forward(&values));
    // Eight postures; five joints have two turns each.
    assert_eq!(solutions.len(), 8 * 32);
    for turned in [[0.3 - TAU, -1.2, 1.4, -0.6, 1.1, 0.5], [0.3, -1.2 + TAU, 1.4, -0.6, 1.1 - TAU, 0.5]] {
        assert!(solutions.iter().any(|solution| is_near(solution, &turned, 1e-9)), "{turned:?}");
    }
}

#[test]
fn the_nearest_solution_comes_first() {
    let mut random = Random::new(8, 0);
    for name in ["ur10e", "kr6_r900", "panda"] {
        let arm = Arm::preset(name).unwrap();
        for _ in 0..10 {
            let values = random_values(&arm, &mut random);
            let pose = arm.forward(&values);
            let near: Vec<f64> = values.iter().map(|value| value + 1e-4 * random.range(-1.0, 1.0)).collect();
            let solutions = arm.inverse_near(&pose, &near);
            assert!(is_near(&solutions[0], &values, 5e-3), "{name}: {values:?}, {:?}", solutions[0]);
            let times: Vec<f64> = solutions
                .iter()
                .map(|solution| {
                    let time = |i: usize| (solution[i] - near[i]).abs() / arm.joints[i].limits.velocity;
                    (0..arm.n_joints()).map(time).fold(0.0, f64::max)
                })
                .collect();
            assert!(times.is_sorted());
        }
    }
}

#[test]
fn a_pose_out_of_reach_has_no_solutions() {
    for name in crate::presets::NAMES {
        let arm = Arm::preset(name).unwrap();
        let far = Pose::new(DQuat::IDENTITY, DVec3::new(2.0, 0.0, 0.3)).unwrap();
        assert!(arm.inverse(&far).is_empty(), "{name}");
        assert!(arm.inverse_near(&far, &vec![0.0; arm.n_joints()]).is_empty(), "{name}");
    }
}

fn joint(kind: JointKind, offset: DVec3, axis: DVec3, range: f64) -> Joint {
    let limits = JointLimits { lower: -range, upper: range, velocity: 1.0, acceleration: 1.0 };
    let parent_from_joint = Pose::new(DQuat::IDENTITY, offset).unwrap();
    Joint { name: format!("{offset}{axis}"), kind, parent_from_joint, axis, limits }
}

fn arm(joints: Vec<Joint>) -> Arm {
    let links = (0..=joints.len()).map(|i| Link { name: i.to_string(), shapes: Vec::new() }).collect();
    let last_link_from_flange = Pose::new(DQuat::from_rotation_y(0.4), DVec3::new(0.1, 0.02, 0.0)).unwrap();
    Arm { name: "made".into(), joints, links, last_link_from_flange, may_touch: Vec::new() }
}

/// Arms that are not in textbooks: fewer joints, sliding ones, skew axes.
#[test]
fn other_arms_are_solved_by_numbers() {
    let turning = |offset: [f64; 3], axis: [f64; 3]| {
        joint(JointKind::Revolute, offset.into(), DVec3::from(axis).normalize(), 3.0)
    };
    let sliding = |offset: [f64; 3], axis| joint(JointKind::Prismatic, offset.into(), axis, 0.4);
    let skew = vec![
        turning([0.0, 0.0, 0.3], [0.0, 0.2, 1.0]),
        turning([0.1, 0.0, 0.1], [0.1, 1.0, 0.0]),
        turning([0.4, 0.0, 0.0], [0.0, 1.0, 0.3]),
        turning([0.1, 0.1, 0.0], [1.0, 0.0, 0.0]),
        turning([0.3, 0.0, 0.0], [0.0, 1.0, 0.0]),
        turning([0.1, 0.1, 0.0], [1.0, 0.0, 0.5]),
    ];
    let slides = vec![sliding([0.0; 3], DVec3::X), sliding([0.0; 3], DVec3::Y), sliding([0.0; 3], DVec3::Z)];
    let five = skew[..5].to_vec();
    let mut eight = skew.clone();
    eight.extend([sliding([0.1, 0.0, 0.0], DVec3::X), turning([0.0, 0.1, 0.0], [0.0, 0.0, 1.0])]);
    let mut random = Random::new(2, 0);
    for joints in [skew, slides, five, eight] {
        let arm = arm(joints);
        for _ in 0..10 {
            let pose = arm.forward(&random_values(&arm, &mut random));
            let solutions = arm.inverse(&pose);
            assert!(!solutions.is_empty(), "{} joints", arm.n_joints());
            solutions.iter().for_each(|solution| assert_reaches(&arm, solution, &pose));
        }
    }
}

/// Any joint may be held: a rail under an arm, or the third axis of an arm with meeting shoulder and wrist
/// axes.
#[test]
fn a_seventh_joint_is_found_by_the_geometry() {
    let panda = Arm::preset("panda").unwrap();
    assert_eq!(redundant::held_joint(&panda), Some(6));

    let mut on_rail = Arm::preset("kr6_r900").unwrap();
    on_rail.joints.insert(0, joint(JointKind::Prismatic, DVec3::ZERO, DVec3::Y, 0.5));
    on_rail.links.insert(0, Link { name: "rail".into(), shapes: Vec::new() });
    assert_eq!(redundant::held_joint(&on_rail), Some(0));

    let axes = [DVec3::Z, DVec3::Y, DVec3::Z, DVec3::Y, DVec3::Z, DVec3::Y, DVec3::Z];
    let heights = [0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.1];
    let human = axes
        .iter()
        .zip(heights)
        .map(|(axis, height)| joint(JointKind::Revolute, height * DVec3::Z, *axis, 2.5))
        .collect();
    let human = arm(human);
    assert!(redundant::held_joint(&human).is_some());

    let mut random = Random::new(4, 0);
    for arm in [on_rail, human] {
        for _ in 0..20 {
            let values = random_values(&arm, &mut random);
            let pose = arm.forward(&values);
            let solutions = arm.inverse_near(&pose, &values);
            solutions.iter().for_each(|solution| assert_reaches(&arm, solution, &pose));
            assert!(is_near(&solutions[0], &values, 1e-5));
            assert!(!arm.inverse(&pose).is_empty());
        }
    }
}

proptest! {
    /// Any pose and any reference values, including absurd ones.
    #[test]
    fn any_pose_is_solved_or_not(
        which in 0..crate::presets::NAMES.len(),
        at in prop::array::uniform3(prop_oneof![-1.5..1.5, -1e8..1e8, Just(0.0)]),
        turn in prop::array::uniform3(prop_oneof![-4.0..4.0, Just(0.0), Just(PI)]),
        near in prop::array::uniform7(prop_oneof![-7.0..7.0, Just(0.0), any::<f64>()]),
    ) {
        let arm = Arm::preset(crate::presets::NAMES[which]).unwrap();
        let pose = Pose::new(DQuat::from_scaled_axis(turn.into()), at.into()).unwrap();
        let near: Vec<f64> = near[..arm.n_joints()].iter().map(|x: &f64| if x.is_finite() { *x } else { 0.0 }).collect();
        for solution in arm.inverse(&pose).iter().chain(&arm.inverse_near(&pose, &near)) {
            assert_reaches(&arm, solution, &pose);
        }
    }
}
