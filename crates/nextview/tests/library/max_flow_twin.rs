//! The max-flow planner against a slow twin of the paper's equations that shares nothing with it but the
//! camera's poses: frontier, object probability, rays, their visibility and the fewest views are worked out
//! here once more, each in the most obvious way.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DVec2, DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::{Lattice, Pose, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::planner::{MaxFlow, MaxFlowConfig, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::{ViewSpace, generate};
use nextview::visibility::FreeSpace;

/// Voxels along the box, and their edge in metres.
const N: i32 = 12;
const EDGE: f64 = 0.01;
const N_VIEWS: usize = 12;
const FOCAL: f64 = 400.0;
const SIZE: DVec2 = DVec2::new(320.0, 240.0);

/// Planning rays end below this visibility.
const FADED: f64 = 1e-3;

/// What is known of a voxel.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    Free(f64),
    Unknown,
    Occupied,
}

/// A ball of which one side was measured: free space around that side, here and there measured twice.
fn log_odds(key: IVec3) -> Option<f32> {
    let center = EDGE * (key.as_dvec3() + 0.5);
    let radius = center.distance(DVec3::new(0.003, -0.002, 0.001));
    match center.x > 0.0 {
        true if (0.03..0.042).contains(&radius) => Some(0.85),
        true if radius >= 0.042 => Some(if key.y > 1 { -0.8 } else { -0.4 }),
        _ => None,
    }
}

fn voxels() -> Vec<IVec3> {
    let along = || -N / 2..N / 2;
    along().flat_map(|z| along().flat_map(move |y| along().map(move |x| IVec3::new(x, y, z)))).collect()
}

fn known(key: IVec3) -> Known {
    match log_odds(key).map(f64::from) {
        None => Known::Unknown,
        Some(odds) if odds > 0.0 => Known::Occupied,
        Some(odds) => Known::Free(1.0 / (1.0 + (-odds).exp())),
    }
}

/// H(x) P(obj_x) of every voxel: eq. (2) without visibility.
fn weights(voxels: &[IVec3]) -> Vec<f64> {
    let touches = |key: IVec3, is: fn(Known) -> bool| {
        voxels.iter().any(|other| (*other - key).abs().max_element() == 1 && is(known(*other)))
    };
    let is_frontier = |key: &IVec3| {
        known(*key) == Known::Unknown
            && touches(*key, |other| other == Known::Occupied)
            && touches(*key, |other| matches!(other, Known::Free(_)))
    };
    let frontier: Vec<IVec3> = voxels.iter().copied().filter(is_frontier).collect();
    assert!(frontier.len() > 20);
    let weight = |key: &IVec3| {
        if known(*key) != Known::Unknown {
            return 0.0;
        }
        let mut distances: Vec<f64> =
            frontier.iter().map(|other| EDGE * (*other - *key).as_dvec3().length()).collect();
        distances.sort_by(f64::total_cmp);
        let alpha = 0.1 / EDGE;
        let object: f64 = distances[..6].iter().map(|d| (-(alpha * d).powi(2)).exp()).product();
        let half: f64 = 0.5;
        object * -(half * half.ln() + half * half.ln())
    };
    voxels.iter().map(weight).collect()
}

/// The box that rays are sent to, metres. A margin that passes all of a ray is left out.
fn aim(voxels: &[IVec3], free_space: FreeSpace) -> [DVec3; 2] {
    let counts = |key: &&IVec3| free_space == FreeSpace::Fades || !matches!(known(**key), Known::Free(_));
    let inside: Vec<&IVec3> = voxels.iter().filter(counts).collect();
    let low = inside.iter().fold(IVec3::MAX, |low, key| low.min(**key));
    let high = inside.iter().fold(IVec3::MIN, |high, key| high.max(**key));
    [EDGE * low.as_dvec3(), EDGE * (high + 1).as_dvec3()]
}

/// The rays of a view, world frame: a grid over the part of the image that shows the box, `spacing` voxels
/// apart at its far side or less.
fn rays(view: &Pose, aim: [DVec3; 2], spacing: f64) -> Vec<DVec3> {
    let center = 0.5 * (SIZE - 1.0);
    let corners = (0..8).map(|i| {
        let side = |axis: usize| aim[i >> axis & 1][axis];
        view.inverse().transform_point(DVec3::new(side(0), side(1), side(2)))
    });
    let (mut low, mut high, mut depth) = (DVec2::INFINITY, DVec2::NEG_INFINITY, 0.0_f64);
    for corner in corners {
        let pixel = FOCAL * corner.truncate() / corner.z + center;
        (low, high, depth) = (low.min(pixel), high.max(pixel), depth.max(corner.z));
    }
    let (low, high) = (low.max(DVec2::splat(-0.5)), high.min(SIZE - 0.5));
    let n = ((high - low) / (spacing * EDGE * FOCAL / depth)).ceil();
    let mut rays = Vec::new();
    for row in 0..n.y as usize {
        for column in 0..n.x as usize {
            let pixel = low + (high - low) / n * (DVec2::new(column as f64, row as f64) + 0.5);
            rays.push(view.rotation() * ((pixel - center) / FOCAL).extend(1.0));
        }
    }
    rays
}

/// The voxels that a ray from here goes through, nearest first: each is tried.
fn on_ray(voxels: &[IVec3], from: DVec3, direction: DVec3) -> Vec<usize> {
    let mut met: Vec<(f64, usize)> = Vec::new();
    for (index, key) in voxels.iter().enumerate() {
        let a = (EDGE * key.as_dvec3() - from) / direction;
        let b = (EDGE * (key.as_dvec3() + 1.0) - from) / direction;
        let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
        if enter < leave && enter > 0.0 {
            met.push((enter, index));
        }
    }
    met.sort_by(|a, b| a.0.total_cmp(&b.0));
    met.into_iter().map(|(_, index)| index).collect()
}

/// For each view, the largest quality Q of every voxel along its rays, and eq. (1).
fn look(voxels: &[IVec3], view: &Pose, config: &MaxFlowConfig, weights: &[f64]) -> (Vec<f64>, f64) {
    let (mut best, mut sum) = (vec![0.0_f64; voxels.len()], 0.0);
    for direction in rays(view, aim(voxels, config.free_space), config.ray_spacing) {
        let mut visibility = 1.0;
        for index in on_ray(voxels, view.translation(), direction) {
            let passed = match known(voxels[index]) {
                Known::Occupied => break,
                Known::Unknown => 0.5,
                Known::Free(p) if config.free_space == FreeSpace::Fades => 1.0 - p,
                Known::Free(_) => 1.0,
            };
            let quality = weights[index] * visibility;
            best[index] = best[index].max(quality);
            sum += quality;
            visibility *= passed;
            if visibility < FADED {
                break;
            }
        }
    }
    (best, sum)
}

/// For every voxel that some view shows, the views that show it best, one bit each.
fn best_views(looks: &[(Vec<f64>, f64)], n_voxels: usize) -> Vec<u32> {
    let of_voxel = |index: usize| {
        let largest = looks.iter().map(|(best, _)| best[index]).fold(0.0, f64::max);
        let is_best = |view: &usize| largest > 0.0 && looks[*view].0[index] >= largest * (1.0 - 1e-6);
        (0..looks.len()).filter(is_best).fold(0, |views, view| views | 1 << view)
    };
    (0..n_voxels).map(of_voxel).filter(|views| *views != 0).collect()
}

#[test]
fn plans_as_a_slow_twin_does() {
    let (voxels, lattice) = (voxels(), Lattice::new(EDGE).unwrap());
    let block = VoxelBlock::new(IVec3::splat(-N / 2), UVec3::splat(N as u32)).unwrap();
    let snapshot = Snapshot::from_fn(lattice, block, |key| log_odds(key).map(LogOdds));
    // They look past the corner of the voxels in the middle, where a ray would touch four of them.
    let views: ViewSpace = generate::shell(DVec3::new(0.0017, -0.0023, 0.0009), 0.07, N_VIEWS, 11).unwrap();
    let camera =
        Intrinsics::pinhole(SIZE.x as u32, SIZE.y as u32, DVec2::splat(FOCAL), 0.5 * (SIZE - 1.0)).unwrap();
    let weights = weights(&voxels);
    for free_space in [FreeSpace::Clear, FreeSpace::Fades] {
        for (gamma, uses_history) in [(0.0, true), (0.5, true), (0.5, false), (1.0, true)] {
            let config = MaxFlowConfig { gamma, uses_history, ray_spacing: 1.3, free_space, theta: 0.0 };
            let mut planner = MaxFlow::new(config).unwrap();
            let mut visited = vec![0];
            for _ in 0..4 {
                let cancel = Cancel::default();
                let situation = Situation::new(&snapshot, &views, &camera, &cancel);
                let plan = planner.plan(&situation.with_visited(&visited).unwrap()).unwrap();
                let choice = plan.choice.unwrap();
                let nothing = || (vec![0.0; voxels.len()], 0.0);
                let looks: Vec<_> = (0..N_VIEWS)
                    .map(|view| match visited.contains(&view) {
                        true => nothing(),
                        false => look(&voxels, &views.pose(view), &config, &weights),
                    })
                    .collect();
                // V_global: views that serve every voxel at its best, and no fewer do. Which of several such
                // sets it is, the planner chooses.
                let mut flow = [0.0; N_VIEWS];
                if gamma > 0.0 {
                    let best = best_views(&looks, voxels.len());
                    let serves = |views: u32| best.iter().all(|best| best & views != 0);
                    let fewest = (0_u32..1 << N_VIEWS).filter(|views| serves(*views));
                    let fewest = fewest.map(u32::count_ones).min().unwrap();
                    let bits = |views: &Vec<u32>| views.iter().fold(0, |bits, view| bits | 1 << view);
                    let chosen = planner.history().last().unwrap();
                    assert!(serves(bits(chosen)) && chosen.len() == fewest as usize, "{chosen:?}, {fewest}");
                    for (age, optimal) in planner.history().iter().rev().enumerate() {
                        let his = if uses_history || age == 0 { (-(age as f64)).exp() } else { 0.0 };
                        optimal.iter().for_each(|&view| flow[view as usize] += his);
                    }
                }
                let share = |value: f64, all: f64| if all > 0.0 { value / all } else { 0.0 };
                let all: f64 = looks.iter().map(|(_, sum)| sum).sum();
                let score = |view: usize| {
                    let flow_share = share(flow[view], flow.iter().sum());
                    (1.0 - gamma) * share(looks[view].1, all) + gamma * flow_share
                };
                let open = (0..N_VIEWS).filter(|view| !visited.contains(view) && looks[*view].1 > 0.0);
                let largest = open.map(score).fold(0.0, f64::max);
                let case = format!("{free_space:?}, gamma {gamma}, history {uses_history}, {visited:?}");
                assert!((choice.score - largest).abs() < 1e-6, "{case}: {} is not {largest}", choice.score);
                assert!((score(choice.view) - largest).abs() < 1e-6, "{case}: view {}", choice.view);
                visited.push(choice.view);
            }
        }
    }
}
