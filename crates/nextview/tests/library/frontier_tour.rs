//! The frontier tour against its definition: the frontier voxels that views see by the general walk, and all
//! orders of the views of the cover.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::flow::{Incidence, fewest_sets};
use nextview::geometry::{Lattice, SegmentWalk, VoxelBlock};
use nextview::map::{LogOdds, Occupancy, Snapshot, frontier};
use nextview::motion::{KeepOut, tour_length};
use nextview::planner::{FrontierTour, Plan, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::{ViewSpace, generate};
use nextview::visibility::RayGrid;

const SPACING: f64 = 1.5;

/// A ball whose side towards +x was measured; the rest is unknown, and so is the last corner, so that there
/// is no free margin that rays would leave out.
fn half_seen_ball() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap();
    let lattice = Lattice::new(0.01).unwrap();
    Snapshot::from_fn(lattice, block, |key| {
        let center = lattice.center(key);
        match center.x > 0.0 && key != IVec3::splat(7) {
            true if (0.04..0.052).contains(&center.length()) => Some(LogOdds(0.85)),
            true if center.length() >= 0.052 => Some(LogOdds(-0.4)),
            _ => None,
        }
    })
}

fn views() -> ViewSpace {
    generate::shell(DVec3::ZERO, 0.08, 60, 5).unwrap()
}

fn plan(snapshot: &Snapshot, visited: &[usize]) -> Plan {
    let (views, camera, cancel) = (views(), Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, &views, &camera, &cancel).with_visited(visited).unwrap();
    FrontierTour::new(SPACING).unwrap().plan(&situation).unwrap()
}

/// Whether the view has a ray to the voxel that nothing occupied hides, and fewer than ten unknown voxels.
fn seen(snapshot: &Snapshot, view: usize) -> Vec<bool> {
    let (lattice, block, pose) = (snapshot.lattice(), snapshot.block(), views().pose(view));
    let grid = RayGrid::new(&Intrinsics::d435i());
    let mut seen = vec![false; block.n_voxels()];
    for direction in grid.directions(&pose, &lattice.bounds(&block), SPACING * lattice.voxel_size()) {
        let (origin, direction) = (lattice.to_voxels(pose.translation()), pose.rotation_matrix() * direction);
        let walk = SegmentWalk::ray_within(origin, direction, block.min(), block.max());
        let (mut walk, mut n_unknown) = (walk, 0);
        while let Some(at) = &mut walk {
            let voxel = block.index(at.key()).unwrap();
            match snapshot.occupancy()[voxel] {
                Occupancy::Occupied => break,
                Occupancy::Unknown => n_unknown += 1,
                Occupancy::Free => (),
            }
            seen[voxel] = true;
            // 0.5^10 is below a thousandth.
            if n_unknown == 10 || at.advance().is_none() {
                break;
            }
        }
    }
    seen
}

/// All orders of the numbers below `n`.
fn orders(n: usize) -> Vec<Vec<usize>> {
    if n == 0 {
        return vec![Vec::new()];
    }
    let insert = |order: &Vec<usize>, place: usize| {
        let mut order = order.clone();
        order.insert(place, n - 1);
        order
    };
    orders(n - 1).iter().flat_map(|order| (0..n).map(move |place| insert(order, place))).collect()
}

#[test]
fn the_choice_is_the_first_view_of_the_shortest_tour_past_the_frontier() {
    let snapshot = half_seen_ball();
    let frontier = frontier(&snapshot);
    assert!(frontier.len() > 50);
    for visited in [&[3][..], &[11, 40], &[7, 30, 52]] {
        let open: Vec<usize> = (0..60).filter(|view| !visited.contains(view)).collect();
        let sees: Vec<Vec<bool>> = open.iter().map(|&view| seen(&snapshot, view)).collect();
        let viewers = |voxel: usize| (0..open.len() as u32).filter(move |&set| sees[set as usize][voxel]);
        let rows: Vec<Vec<u32>> = frontier.iter().map(|&voxel| viewers.clone()(voxel).collect()).collect();
        let cover = fewest_sets(&Incidence::from_rows(open.len(), rows.clone()), &Cancel::default()).unwrap();
        assert!(rows.iter().all(|row| row.is_empty() || row.iter().any(|set| cover.contains(set))));
        assert!((2..9).contains(&cover.len()), "{}", cover.len());

        let place = |view: usize| views().pose(view).translation();
        let ball = KeepOut::around(&snapshot.lattice().bounds(&snapshot.block()), 0.0).unwrap();
        let start = Some(place(*visited.last().unwrap()));
        let tour =
            |order: &[usize]| -> Vec<usize> { order.iter().map(|&i| open[cover[i] as usize]).collect() };
        let length = |tour: &[usize]| tour_length(start, tour.iter().map(|&view| place(view)), &ball);
        let tours = orders(cover.len()).into_iter().map(|order| tour(&order));
        let shortest = tours.min_by(|a, b| length(a).total_cmp(&length(b))).unwrap();

        let choice = plan(&snapshot, visited).choice.unwrap();
        assert_eq!((choice.view, choice.runner_up), (shortest[0], Some(shortest[1])));
        let explanation = choice.explanation.unwrap();
        assert_eq!(explanation.get("tour_views"), Some(cover.len() as f64));
        assert!((explanation.get("tour_length_m").unwrap() - length(&shortest)).abs() < 1e-12);
        let n_seen = seen_of(&frontier, &seen(&snapshot, choice.view));
        assert_eq!(explanation.get("seen_frontier_voxels"), Some(n_seen));
        assert_eq!(choice.score, n_seen / frontier.len() as f64);
    }
}

fn seen_of(frontier: &[usize], seen: &[bool]) -> f64 {
    frontier.iter().filter(|&&voxel| seen[voxel]).count() as f64
}

#[test]
fn without_a_frontier_there_is_no_choice() {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    let unknown = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
    assert_eq!(plan(&unknown, &[]), Plan::default());
    let all: Vec<usize> = (0..60).collect();
    assert_eq!(plan(&half_seen_ball(), &all), Plan::default());
}

#[test]
fn threads_do_not_show() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| plan(&half_seen_ball(), &[4]))
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn refuses_rays_without_a_distance() {
    assert!(FrontierTour::new(0.0).is_err() && FrontierTour::new(f64::NAN).is_err());
}
