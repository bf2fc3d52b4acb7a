//! What the planner makes of the direction that the network names.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::planner::{Plan, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::{ViewSpace, generate};
use nextview_learned::Grid;
use nextview_learned::nbv_regression::{NbvRegression, Network};

/// A box, not around the origin, in which a slab is known.
fn snapshot() -> Snapshot {
    let block = VoxelBlock::new(IVec3::new(4, -13, -20), UVec3::new(26, 20, 24)).unwrap();
    let log_odds = |key: IVec3| match key.x - block.min().x {
        16 => Some(LogOdds(1.5)),
        x if x > 16 => Some(LogOdds(-0.8)),
        _ => None,
    };
    Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, log_odds)
}

fn center(snapshot: &Snapshot) -> DVec3 {
    snapshot.lattice().bounds(&snapshot.block()).center()
}

fn plan(snapshot: &Snapshot, views: &ViewSpace, visited: &[usize]) -> Plan {
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, views, &camera, &cancel);
    NbvRegression::default().plan(&situation.with_visited(visited).unwrap()).unwrap()
}

#[test]
fn takes_open_candidates_by_their_angle_to_the_direction() {
    let snapshot = snapshot();
    let views = generate::shell(center(&snapshot), 0.1, 40, 3).unwrap();
    let direction = Network::default().direction(&Grid::new(&snapshot));
    assert!(direction.is_normalized());
    let angle = |view: usize| (views.pose(view).translation() - center(&snapshot)).angle_between(direction);
    let mut expected: Vec<usize> = (0..40).collect();
    expected.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    let mut visited = Vec::new();
    for (n, &view) in expected.iter().enumerate() {
        let choice = plan(&snapshot, &views, &visited).choice.unwrap();
        assert_eq!((choice.view, choice.runner_up), (view, expected.get(n + 1).copied()));
        assert!((choice.score - angle(view).cos()).abs() < 1e-12);
        visited.push(view);
    }
    assert_eq!(plan(&snapshot, &views, &visited), Plan::default(), "all were taken");
}

#[test]
fn candidates_out_of_reach_are_left_out() {
    let snapshot = snapshot();
    let views = generate::fibonacci_sphere(center(&snapshot), 0.4, 50).unwrap();
    let best = plan(&snapshot, &views, &[]).choice.unwrap();
    let out_of_reach = views.pose(best.view).translation();
    let views = views.restricted(|position| position != out_of_reach);
    assert_eq!(plan(&snapshot, &views, &[]).choice.map(|choice| choice.view), best.runner_up);
}
