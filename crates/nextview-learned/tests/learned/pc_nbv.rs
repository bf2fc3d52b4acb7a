//! What the planner makes of the gains that the network predicts.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::planner::{Plan, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::{ViewSpace, generate, look_at};
use nextview_learned::fixed_views;
use nextview_learned::pc_nbv::{Cloud, Network, PcNbv, views};

/// A box in which half of a ball was seen.
fn snapshot() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-13), UVec3::splat(26)).unwrap();
    let log_odds = |key: IVec3| match key.length_squared() {
        64..81 if key.x > 0 => Some(LogOdds(1.5)),
        81.. if key.x > 0 => Some(LogOdds(-0.8)),
        _ => None,
    };
    Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, log_odds)
}

fn plan(snapshot: &Snapshot, candidates: &ViewSpace, visited: &[usize]) -> Plan {
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, candidates, &camera, &cancel);
    PcNbv::default().plan(&situation.with_visited(visited).unwrap()).unwrap()
}

/// The 33 views themselves in reverse order, and behind each a candidate that is farther away.
fn candidates(snapshot: &Snapshot) -> ViewSpace {
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let poses = fixed_views::positions(&bounds, &views::DIRECTIONS)
        .into_iter()
        .rev()
        .flat_map(|position| [position, 1.3 * position].map(|at| look_at(at, DVec3::ZERO).unwrap()));
    ViewSpace::new(poses.collect()).unwrap()
}

/// The candidate of view `k` among those.
fn candidate(k: usize) -> usize {
    2 * (views::N_VIEWS - 1 - k)
}

#[test]
fn takes_the_view_of_the_largest_gain_that_was_not_visited() {
    let snapshot = snapshot();
    let candidates = candidates(&snapshot);
    let cloud = Cloud::new(&snapshot, &Cancel::default()).unwrap();
    // Behind view 5: that view was visited, too.
    let mut taken = vec![candidate(5) + 1];
    let mut is_visited = [false; views::N_VIEWS];
    is_visited[5] = true;
    for n in 1..views::N_VIEWS {
        let gains = Network::default().gains(&cloud, &is_visited);
        let mut open: Vec<usize> = (0..views::N_VIEWS).filter(|&view| !is_visited[view]).collect();
        open.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
        let choice = plan(&snapshot, &candidates, &taken).choice.unwrap();
        assert_eq!(choice.view, candidate(open[0]), "choice {n}");
        assert_eq!(choice.runner_up, open.get(1).map(|&next| candidate(next)));
        assert_eq!(choice.score, f64::from(gains[open[0]]));
        is_visited[open[0]] = true;
        taken.push(choice.view);
    }
    assert_eq!(plan(&snapshot, &candidates, &taken), Plan::default(), "all 33 were taken");
}

#[test]
fn takes_no_candidate_twice_however_few_there_are() {
    let snapshot = snapshot();
    let candidates = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 3).unwrap();
    let mut taken = Vec::new();
    while let Some(choice) = plan(&snapshot, &candidates, &taken).choice {
        assert!(!taken.contains(&choice.view));
        assert_ne!(choice.runner_up, Some(choice.view));
        taken.push(choice.view);
    }
    assert!(!taken.is_empty());
    assert_eq!(plan(&snapshot, &candidates.restricted(|_| false), &[]), Plan::default());
}
