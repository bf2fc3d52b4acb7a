//! What the planner makes of the network's answer.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::planner::{Plan, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::{ViewSpace, generate, look_at};
use nextview_learned::nbv_net::{NbvNet, Network, views};
use nextview_learned::{Grid, fixed_views};

/// A box of 26 voxels of 1 cm a side in which a slab is known.
fn snapshot() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-13), UVec3::splat(26)).unwrap();
    let log_odds = |key: IVec3| match key.x + key.z / 4 {
        3 => Some(LogOdds(1.5)),
        x if x > 3 => Some(LogOdds(-0.8)),
        _ => None,
    };
    Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, log_odds)
}

fn plan(snapshot: &Snapshot, views: &ViewSpace, visited: &[usize]) -> Plan {
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, views, &camera, &cancel);
    NbvNet::default().plan(&situation.with_visited(visited).unwrap()).unwrap()
}

/// The 14 views, from the best to the worst that the network names.
fn ranking(snapshot: &Snapshot) -> Vec<usize> {
    let logits = Network::default().logits(&Grid::new(snapshot));
    let mut ranking: Vec<usize> = (0..views::N_VIEWS).collect();
    ranking.sort_by(|&a, &b| logits[b].total_cmp(&logits[a]));
    ranking
}

/// The 14 views themselves in reverse order, each a little off, between candidates that are farther away.
fn candidates(snapshot: &Snapshot) -> ViewSpace {
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let mut random = Random::new(4, 0);
    let poses = fixed_views::positions(&bounds, &views::DIRECTIONS).into_iter().rev().flat_map(|position| {
        let near = position + 0.01 * random.in_cube();
        [near, position + 0.1 * random.in_cube().normalize()].map(|at| look_at(at, DVec3::ZERO).unwrap())
    });
    ViewSpace::new(poses.collect()).unwrap()
}

/// The candidate of view `k` among those.
fn candidate(k: usize) -> usize {
    2 * (views::N_VIEWS - 1 - k)
}

#[test]
fn takes_the_candidates_nearest_to_the_views_in_the_order_of_the_network() {
    let snapshot = snapshot();
    let (views, ranking) = (candidates(&snapshot), ranking(&snapshot));
    let mut visited = vec![1, 7];
    let mut last_score = 1.0;
    for (n, &view) in ranking.iter().enumerate() {
        let choice = plan(&snapshot, &views, &visited).choice.unwrap();
        assert_eq!(choice.view, candidate(view), "choice {n}");
        assert_eq!(choice.runner_up, ranking.get(n + 1).map(|&next| candidate(next)));
        assert!((0.0..=last_score).contains(&choice.score), "{choice:?}");
        last_score = choice.score;
        visited.push(choice.view);
    }
    assert_eq!(plan(&snapshot, &views, &visited), Plan::default(), "all 14 were taken");
}

#[test]
fn candidates_out_of_reach_stand_for_no_view() {
    let snapshot = snapshot();
    let best = candidate(ranking(&snapshot)[0]);
    let views = candidates(&snapshot);
    let out_of_reach = views.pose(best).translation();
    let views = views.restricted(|position| position != out_of_reach);
    assert_ne!(plan(&snapshot, &views, &[]).choice.unwrap().view, best);
    assert_eq!(plan(&snapshot, &views.restricted(|_| false), &[]), Plan::default());
}

#[test]
fn one_candidate_may_stand_for_several_views() {
    let snapshot = snapshot();
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 3).unwrap();
    let mut visited = Vec::new();
    while let Some(choice) = plan(&snapshot, &views, &visited).choice {
        assert_ne!(choice.runner_up, Some(choice.view));
        visited.push(choice.view);
    }
    visited.sort_unstable();
    assert_eq!(visited, [0, 1, 2]);
}

#[test]
fn scores_are_probabilities() {
    let snapshot = snapshot();
    let (views, ranking) = (candidates(&snapshot), ranking(&snapshot));
    let score = |n: usize| {
        let visited: Vec<usize> = ranking[..n].iter().map(|&view| candidate(view)).collect();
        plan(&snapshot, &views, &visited).choice.unwrap().score
    };
    let total: f64 = (0..views::N_VIEWS).map(score).sum();
    assert!((total - 1.0).abs() < 1e-9, "{total}");
}
