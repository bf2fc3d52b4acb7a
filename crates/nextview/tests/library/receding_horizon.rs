//! The receding horizon planner against its definition: the same random samples, branches as lists of views,
//! and every sum anew.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::half_seen_ball::half_seen_ball;
use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::gain::UnobservedVoxel;
use nextview::geometry::random::Random;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::motion::KeepOut;
use nextview::planner::{Greedy, GreedyConfig, Plan, RecedingHorizon, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::{ViewSpace, generate};

const SPACING: f64 = 2.0;

fn known() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| Some(LogOdds(-0.4)))
}

fn views() -> ViewSpace {
    generate::fibonacci_sphere(DVec3::ZERO, 0.4, 200).unwrap()
}

fn with_situation<T>(snapshot: &Snapshot, visited: &[usize], use_it: impl FnOnce(&Situation<'_>) -> T) -> T {
    let (views, camera, cancel) = (views(), Intrinsics::d435i(), Cancel::default());
    use_it(&Situation::new(snapshot, &views, &camera, &cancel).with_visited(visited).unwrap())
}

fn plan(planner: &mut RecedingHorizon, snapshot: &Snapshot, visited: &[usize]) -> Plan {
    with_situation(snapshot, visited, |situation| planner.plan(situation).unwrap())
}

/// The best branch and its gain, for gains by view.
fn best_branch(gains: &[f64], visited: &[usize], rest: &[usize], seed: u64) -> (Vec<usize>, f64) {
    let views = views();
    let place = |view: usize| views.pose(view).translation();
    let here = place(*visited.last().unwrap());
    let half = 0.08_f64;
    let ball = KeepOut::new(DVec3::ZERO, (3.0 * half * half).sqrt(), 0.0).unwrap();
    let length = |a: DVec3, b: DVec3| ball.path_length(a, b) / 0.4;
    let end = |branch: &[usize]| branch.last().map_or(here, |&view| place(view));
    // The sum over the views of the branch, each discounted by the whole path to it.
    let gain = |branch: &[usize]| -> f64 {
        let (mut sum, mut path, mut from) = (0.0, 0.0, here);
        for &view in branch {
            path += length(from, place(view));
            sum += gains[view] * (-0.5 * path).exp();
            from = place(view);
        }
        sum
    };
    // Every branch of the tree, the root first.
    let mut branches: Vec<Vec<usize>> = vec![Vec::new()];
    (1..=rest.len()).for_each(|n| branches.push(rest[..n].to_vec()));
    let mut random = Random::new(seed, visited.len() as u64);
    while branches.len() <= 15 {
        let sample = random.in_cube();
        if sample.length() > 1.0 {
            continue;
        }
        let target = 0.4 * sample.normalize();
        let distance = |branch: &Vec<usize>| end(branch).distance(target);
        let nearest = branches.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let is_new =
            |view: &usize| !visited.contains(view) && branches.iter().all(|b| b.last() != Some(view));
        let reached = |view: &usize| length(end(nearest), place(*view)) <= 0.5;
        let open = (0..views.len()).filter(is_new).filter(reached);
        let next = open.min_by(|&a, &b| place(a).distance(target).total_cmp(&place(b).distance(target)));
        let Some(next) = next else { continue };
        let branch = [nearest.as_slice(), &[next]].concat();
        branches.push(branch);
    }
    let best = branches.into_iter().map(|branch| (gain(&branch), branch));
    let (gain, branch) = best.reduce(|best, other| if other.0 > best.0 { other } else { best }).unwrap();
    (branch, gain)
}

#[test]
fn takes_the_first_view_of_the_best_branch_and_keeps_the_rest() {
    let snapshot = half_seen_ball();
    let gain = Greedy::<UnobservedVoxel>::new(GreedyConfig { ray_spacing: SPACING, theta: 0.0 }).unwrap();
    let all: Vec<usize> = (0..200).collect();
    let gains = with_situation(&snapshot, &[], |situation| gain.gains(situation, &all).unwrap());
    for seed in 0..4 {
        let mut planner = RecedingHorizon::new(SPACING, seed).unwrap();
        let (mut visited, mut rest, mut kept) = (vec![90 + seed as usize], Vec::new(), 0);
        for _ in 0..6 {
            let (branch, gain) = best_branch(&gains, &visited, &rest, seed);
            let choice = plan(&mut planner, &snapshot, &visited).choice.unwrap();
            assert_eq!(choice.view, branch[0]);
            assert!((choice.score - gain).abs() < 1e-9 * gain, "{choice:?} {gain}");
            assert_eq!(choice.explanation.unwrap().get("branch_views"), Some(branch.len() as f64));
            visited.push(choice.view);
            rest = branch[1..].to_vec();
            kept += rest.len();
        }
        assert!(kept > 0, "some branches are longer than a view");
    }
}

#[test]
fn a_view_that_was_not_taken_begins_a_new_tree() {
    let snapshot = half_seen_ball();
    let mut planner = RecedingHorizon::new(SPACING, 1).unwrap();
    plan(&mut planner, &snapshot, &[90]).choice.unwrap();
    // On the other side, no kept view is within reach.
    let elsewhere = plan(&mut planner, &snapshot, &[90, 10]);
    let anew = plan(&mut RecedingHorizon::new(SPACING, 1).unwrap(), &snapshot, &[90, 10]);
    assert_eq!(elsewhere, anew);
}

#[test]
fn stops_when_nothing_is_unknown_or_open() {
    let mut planner = RecedingHorizon::new(SPACING, 0).unwrap();
    assert_eq!(plan(&mut planner, &known(), &[3]), Plan::default());
    let all: Vec<usize> = (0..200).collect();
    assert_eq!(plan(&mut planner, &half_seen_ball(), &all), Plan::default());
    assert!(plan(&mut planner, &half_seen_ball(), &[]).choice.is_some(), "before the first view");
}

#[test]
fn threads_do_not_show() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| plan(&mut RecedingHorizon::new(SPACING, 2).unwrap(), &half_seen_ball(), &[4]))
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn refuses_rays_without_a_distance() {
    assert!(RecedingHorizon::new(0.0, 0).is_err() && RecedingHorizon::new(f64::NAN, 0).is_err());
}
