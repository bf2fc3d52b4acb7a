//! The max-flow planner against the paper's equations written out naively: all rays in a list, all sums by
//! hand; and the greedy planners against the gains of single views.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::half_seen_ball::half_seen_ball;
use glam::{DVec2, DVec3, IVec3, UVec3};
use nextview::flow::{BestSets, fewest_sets};
use nextview::gain::{
    Apora, AreaFactor, AverageEntropy, InformationGain, Krainin, OcclusionAware, Potthast, ProximityCount,
    RearSideEntropy, RearSideVoxel, UnobservedVoxel, object_probability,
};
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot, entropy, frontier};
use nextview::planner::{
    Greedy, GreedyByView, GreedyConfig, InOrder, MaxFlow, MaxFlowConfig, Plan, RandomViews, Situation,
    ViewGain, ViewPlanner,
};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::view::{ViewSpace, generate, look_at};
use nextview::visibility::{FreeSpace, Ray, RayCaster, Sight, ViewRays};
use nextview::{Cancel, Error};

/// An image of the ball from +x.
fn frame_of_ball() -> Frame {
    let camera = Intrinsics::pinhole(64, 48, DVec2::splat(120.0), DVec2::new(31.5, 23.5)).unwrap();
    // Where a ray (x, y, 1) t from 0.4 m away meets a ball of 46 mm: the smaller solution of a quadratic
    // equation.
    let depth = |pixel: u32| {
        let pixel = DVec2::new((pixel % 64) as f64, (pixel / 64) as f64);
        let direction_sq = camera.deproject(pixel).unwrap().extend(1.0).length_squared();
        let root = 0.4_f64.powi(2) - direction_sq * (0.4_f64.powi(2) - 0.046_f64.powi(2));
        if root < 0.0 { f32::INFINITY } else { ((0.4 - root.sqrt()) / direction_sq) as f32 }
    };
    let image = DepthImage::from_metres(64, 48, (0..64 * 48).map(depth).collect()).unwrap();
    Frame::new(image, camera, look_at(DVec3::X * 0.4, DVec3::ZERO).unwrap(), 1.0).unwrap()
}

fn unknown() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    Snapshot::from_fn(Lattice::new(0.02).unwrap(), block, |_| None)
}

fn views() -> ViewSpace {
    generate::shell(DVec3::ZERO, 0.08, 60, 5).unwrap()
}

fn plan(planner: &mut dyn ViewPlanner, snapshot: &Snapshot, visited: &[usize]) -> Plan {
    let views = &views();
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, views, &camera, &cancel);
    planner.plan(&situation.with_visited(visited).unwrap()).unwrap()
}

fn max_flow(config: MaxFlowConfig) -> MaxFlow {
    MaxFlow::new(config).unwrap()
}

/// A quantity of the explanation of a plan's choice.
fn explained(plan: &Plan, name: &str) -> Option<f64> {
    plan.choice.as_ref()?.explanation.as_ref()?.get(name)
}

/// Eqs. (1) to (7) as they stand: the score of every view, and V_global.
fn by_the_equations(
    config: MaxFlowConfig,
    snapshot: &Snapshot,
    visited: &[usize],
    history: &[Vec<u32>],
) -> (Vec<f64>, Vec<u32>) {
    let views = views();
    let cancel = &Cancel::default();
    let object = object_probability(snapshot, &frontier(snapshot), cancel).unwrap();
    let caster =
        RayCaster::new(snapshot, &Intrinsics::d435i(), config.ray_spacing, config.free_space).unwrap();
    let mut edges: Vec<(usize, usize, f64)> = Vec::new(); // view, voxel, quality
    for view in (0..views.len()).filter(|view| !visited.contains(view)) {
        caster.cast(&views.pose(view), |ray| {
            for crossing in ray.crossings {
                let voxel = crossing.voxel as usize;
                let h = entropy(snapshot.probability()[voxel] as f64);
                edges.push((view, voxel, h * object[voxel] * crossing.visibility as f64));
            }
        });
    }
    let mut local = vec![0.0; views.len()];
    edges.iter().for_each(|&(view, _, quality)| local[view] += quality);
    edges.sort_by_key(|edge| edge.1);
    let mut best = BestSets::new(snapshot.block().n_voxels(), views.len());
    for offers in edges.chunk_by(|a, b| a.1 == b.1) {
        let largest = offers.iter().map(|edge| edge.2).fold(0.0, f64::max);
        let best_offers = offers.iter().filter(|edge| edge.2 == largest);
        best_offers.for_each(|&(view, voxel, quality)| best.offer(voxel, view as u32, quality));
    }
    let optimal = fewest_sets(best.candidates(), cancel).unwrap();
    let mut flow = vec![0.0; views.len()];
    let history = if config.uses_history { history } else { &[] };
    let plans: Vec<&Vec<u32>> = history.iter().chain([&optimal]).collect();
    for (k, plan) in plans.iter().enumerate() {
        let his = (-((plans.len() - 1 - k) as f64)).exp();
        plan.iter().for_each(|&view| flow[view as usize] += his);
    }
    let (local_total, flow_total): (f64, f64) = (local.iter().sum(), flow.iter().sum());
    let global = |view: usize| {
        (1.0 - config.gamma) * local[view] / local_total + config.gamma * flow[view] / flow_total
    };
    ((0..views.len()).map(global).collect(), optimal)
}

#[test]
fn plans_as_the_equations_say() {
    let snapshot = half_seen_ball();
    for (free_space, uses_history) in
        [(FreeSpace::Clear, true), (FreeSpace::Fades, true), (FreeSpace::Clear, false)]
    {
        for gamma in [0.25, 0.5, 1.0] {
            let config = MaxFlowConfig { gamma, uses_history, ray_spacing: 1.5, free_space, theta: 0.0 };
            let (mut planner, mut history) = (max_flow(config), Vec::new());
            for visited in [&[3][..], &[3, 17], &[3, 17, 40]] {
                let (scores, optimal) = by_the_equations(config, &snapshot, visited, &history);
                let plan = plan(&mut planner, &snapshot, visited);
                assert_eq!(explained(&plan, "flow_views"), Some(optimal.len() as f64));
                history.push(optimal);
                assert_eq!(planner.history(), history);
                let open = (0..60).filter(|view| !visited.contains(view));
                let best = open.max_by(|&a, &b| scores[a].total_cmp(&scores[b]).then(b.cmp(&a))).unwrap();
                let choice = plan.choice.unwrap();
                assert_eq!(choice.view, best);
                assert!((choice.score - scores[best]).abs() < 1e-12);
                assert!(scores[choice.runner_up.unwrap()] <= choice.score);
            }
        }
    }
}

#[test]
fn without_history_all_optimal_views_weigh_the_same() {
    let snapshot = half_seen_ball();
    let planner =
        |uses_history| max_flow(MaxFlowConfig { uses_history, gamma: 1.0, ..MaxFlowConfig::default() });
    let mut first = planner(false);
    let bare = plan(&mut first, &snapshot, &[]);
    let optimal = &first.history()[0];
    assert_eq!(bare.choice.as_ref().unwrap().view, optimal[0] as usize);
    assert_eq!(explained(&bare, "flow_share"), Some(1.0 / optimal.len() as f64));
    // Earlier plans favour another one of the optimal views, if they count.
    let favourite = *optimal.last().unwrap() as usize;
    let others: Vec<usize> = (0..60).filter(|view| *view != favourite).collect();
    let after_others = |uses_history| {
        let mut planner = planner(uses_history);
        (0..2).for_each(|_| _ = plan(&mut planner, &snapshot, &others));
        plan(&mut planner, &snapshot, &[])
    };
    assert_eq!(after_others(false), bare);
    assert_eq!(after_others(true).choice.unwrap().view, favourite);
}

#[test]
fn looks_at_the_side_not_seen() {
    for gamma in [0.0, 0.5] {
        let mut planner = max_flow(MaxFlowConfig { gamma, ..MaxFlowConfig::default() });
        let plan = plan(&mut planner, &half_seen_ball(), &[]);
        assert_eq!(explained(&plan, "flow_views").is_some(), gamma > 0.0);
        let position = views().pose(plan.choice.unwrap().view).translation();
        // A view from the side sees the rim of what was measured and beyond; one from the front sees nothing
        // new.
        assert!(
            position.normalize().x < 0.7,
            "gamma {gamma}: the ball was seen from +x, the next view is {position}"
        );
    }
}

#[test]
fn of_an_unknown_box_every_voxel_is_served_best_by_its_first_crossing() {
    let mut planner = max_flow(MaxFlowConfig { ray_spacing: 0.5, ..MaxFlowConfig::default() });
    let plan = plan(&mut planner, &unknown(), &[]);
    let [n_views, n_voxels, quality] =
        ["flow_views", "flow_voxels", "flow_quality_nats"].map(|name| explained(&plan, name).unwrap());
    assert!((2.0..60.0).contains(&n_views));
    assert!(quality <= n_voxels * std::f64::consts::LN_2);
}

#[test]
fn stops_when_everything_is_known_or_visited() {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    let known = Snapshot::from_fn(Lattice::new(0.02).unwrap(), block, |_| Some(LogOdds(-1.0)));
    assert_eq!(plan(&mut max_flow(MaxFlowConfig::default()), &known, &[]).choice, None);
    let all: Vec<usize> = (0..60).collect();
    assert_eq!(plan(&mut max_flow(MaxFlowConfig::default()), &unknown(), &all).choice, None);
}

#[test]
fn threads_do_not_show() {
    let snapshot = half_seen_ball();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut planner = max_flow(MaxFlowConfig::default());
            [&[4][..], &[4, 7]].map(|visited| plan(&mut planner, &snapshot, visited))
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

/// The gain of every view, each looked at by itself.
fn gains<G: InformationGain>(snapshot: &Snapshot, ray_spacing: f64) -> Vec<f64> {
    let caster = RayCaster::new(snapshot, &Intrinsics::d435i(), ray_spacing, G::SIGHT).unwrap();
    let (gain, views) = (G::new(snapshot, &[frame_of_ball()], &Cancel::default()).unwrap(), views());
    let of_view = |view: usize| {
        let mut tally = G::Tally::default();
        caster.cast(&views.pose(view), |ray| gain.add(&ray, &mut tally));
        G::total(&tally)
    };
    (0..views.len()).map(of_view).collect()
}

fn greedy<G: InformationGain>(config: GreedyConfig, snapshot: &Snapshot, visited: &[usize]) -> Plan {
    let (views, frames) = (views(), [frame_of_ball()]);
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, &views, &camera, &cancel).with_frames(&frames);
    Greedy::<G>::new(config).unwrap().plan(&situation.with_visited(visited).unwrap()).unwrap()
}

/// Each view's share, less theta times its share of the distances from where the camera is, as section V.D
/// says; the visited ones take no part.
fn utilities(theta: f64, shares: &[f64], visited: &[usize], here: DVec3) -> Vec<f64> {
    let views = views();
    let place = |view: usize| views.pose(view).translation();
    let open = |view: &usize| !visited.contains(view);
    let distance = |view: usize| (place(view) - here).length();
    let far: f64 = (0..60).filter(open).map(distance).sum::<f64>().max(f64::MIN_POSITIVE);
    (0..60).map(|v| (1.0 - theta) * shares[v] - theta * distance(v) / far).collect()
}

fn greedy_takes_the_view_of_largest_utility<G: InformationGain>() {
    let snapshot = half_seen_ball();
    for (theta, visited) in [(0.0, &[][..]), (0.0, &[3, 17]), (0.4, &[]), (0.4, &[3, 17]), (1.0, &[5])] {
        let gains = gains::<G>(&snapshot, 1.5);
        let total: f64 = (0..60).filter(|view| !visited.contains(view)).map(|view| gains[view]).sum();
        let shares: Vec<f64> = gains.iter().map(|gain| gain / total).collect();
        let here = frame_of_ball().world_from_camera().translation();
        let scores = utilities(theta, &shares, visited, here);
        let open = (0..60).filter(|view| !visited.contains(view) && gains[*view] > 0.0);
        let best = open.max_by(|&a, &b| scores[a].total_cmp(&scores[b]).then(b.cmp(&a))).unwrap();
        let choice =
            greedy::<G>(GreedyConfig { ray_spacing: 1.5, theta }, &snapshot, visited).choice.unwrap();
        // Two views of equal utility may differ by rounding.
        assert!((choice.score - scores[best]).abs() < 1e-12, "{choice:?} {best}");
        assert!((scores[choice.view] - scores[best]).abs() < 1e-12);
        let local_share = choice.explanation.unwrap().get("local_share").unwrap();
        assert!((local_share - shares[choice.view]).abs() < 1e-12);
    }
}

fn greedy_shows_no_threads<G: InformationGain>() {
    let config = GreedyConfig { theta: 0.2, ..GreedyConfig::default() };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| greedy::<G>(config, &half_seen_ball(), &[4]))
    };
    let one = run(1);
    assert!(one.choice.is_some());
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

fn greedy_stops_when_nothing_is_left<G: InformationGain>() {
    let all: Vec<usize> = (0..60).collect();
    assert_eq!(greedy::<G>(GreedyConfig::default(), &half_seen_ball(), &all), Plan::default());
}

/// A gain of the library, given all rays of a view at once.
struct AtOnce<G>(Option<G>);

impl<G: InformationGain + Send> ViewGain for AtOnce<G> {
    fn sight(&self) -> Sight {
        G::SIGHT
    }

    fn begin(&mut self, situation: &Situation<'_>) -> Result<(), Error> {
        self.0 = Some(G::new(situation.snapshot(), situation.frames(), situation.cancel())?);
        Ok(())
    }

    fn gain(&mut self, _: &Situation<'_>, view: usize, rays: &ViewRays) -> Result<f64, Error> {
        let gain = self.0.as_ref().ok_or_else(|| Error::Planner(format!("view {view} came first").into()))?;
        let mut tally = G::Tally::default();
        for (ends, &end) in rays.offsets.windows(2).zip(&rays.ends) {
            gain.add(&Ray { crossings: &rays.crossings[ends[0]..ends[1]], end }, &mut tally);
        }
        Ok(G::total(&tally))
    }
}

#[test]
fn a_gain_that_gets_all_rays_of_a_view_at_once_plans_as_one_that_gets_each() {
    fn check<G: InformationGain + Send>() {
        let (snapshot, views, frames) = (half_seen_ball(), views(), [frame_of_ball()]);
        let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
        let config = GreedyConfig { theta: 0.2, ..GreedyConfig::default() };
        let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_frames(&frames);
        let situation = situation.with_visited(&[4, 7]).unwrap();
        let plan = GreedyByView::new(config, AtOnce::<G>(None)).unwrap().plan(&situation).unwrap();
        assert_eq!(plan, greedy::<G>(config, &snapshot, &[4, 7]));
        assert!(plan.choice.is_some());
        cancel.cancel();
        let cancelled = GreedyByView::new(config, AtOnce::<G>(None)).unwrap().plan(&situation);
        assert!(matches!(cancelled, Err(Error::Cancelled(_))));
    }
    check::<UnobservedVoxel>();
    check::<AverageEntropy>();
}

#[test]
fn greedy_planners_plan_as_their_gains_say() {
    fn check<G: InformationGain>() {
        greedy_takes_the_view_of_largest_utility::<G>();
        greedy_shows_no_threads::<G>();
        greedy_stops_when_nothing_is_left::<G>();
    }
    check::<Apora>();
    check::<AreaFactor>();
    check::<AverageEntropy>();
    check::<Krainin>();
    check::<OcclusionAware>();
    check::<Potthast>();
    check::<ProximityCount>();
    check::<RearSideEntropy>();
    check::<RearSideVoxel>();
    check::<UnobservedVoxel>();
}

#[test]
fn a_known_box_gains_nothing_that_only_the_unknown_has() {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    let known = Snapshot::from_fn(Lattice::new(0.02).unwrap(), block, |_| Some(LogOdds(-1.0)));
    let config = GreedyConfig::default();
    assert_eq!(greedy::<UnobservedVoxel>(config, &known, &[]).choice, None);
    assert_eq!(greedy::<Apora>(config, &known, &[]).choice, None);
    assert_eq!(greedy::<RearSideEntropy>(config, &known, &[]).choice, None);
}

#[test]
fn max_flow_pays_for_moving() {
    let snapshot = half_seen_ball();
    let visited = [3, 17];
    let config = |theta| MaxFlowConfig { theta, ..MaxFlowConfig::default() };
    let (scores, _) = by_the_equations(config(0.3), &snapshot, &visited, &[]);
    let here = views().pose(visited[visited.len() - 1]).translation(); // without frames, the last view
    let scores = utilities(0.3, &scores, &visited, here);
    let choice = plan(&mut max_flow(config(0.3)), &snapshot, &visited).choice.unwrap();
    let best = (0..60).filter(|view| !visited.contains(view)).map(|view| scores[view]);
    assert!((choice.score - best.fold(f64::NEG_INFINITY, f64::max)).abs() < 1e-12);
    // With theta = 1 only the way counts: the nearest view that gains anything.
    let nearest = plan(&mut max_flow(config(1.0)), &snapshot, &visited).choice.unwrap();
    let distance = |view: usize| views().pose(view).translation().distance(views().pose(17).translation());
    assert!(distance(nearest.view) < distance(choice.view) || nearest.view == choice.view);
}

#[test]
fn refuses_parameters_out_of_range() {
    for (theta, ray_spacing) in [(-0.1, 1.0), (1.1, 1.0), (f64::NAN, 1.0), (0.5, 0.0), (0.5, f64::NAN)] {
        assert!(Greedy::<Krainin>::new(GreedyConfig { theta, ray_spacing }).is_err());
        assert!(MaxFlow::new(MaxFlowConfig { theta, ray_spacing, ..MaxFlowConfig::default() }).is_err());
    }
    for (gamma, ray_spacing) in [(-0.1, 1.0), (1.1, 1.0), (f64::NAN, 1.0), (0.5, 0.0), (0.5, f64::INFINITY)] {
        assert!(MaxFlow::new(MaxFlowConfig { gamma, ray_spacing, ..MaxFlowConfig::default() }).is_err());
    }
}

#[test]
fn random_views_are_distinct_seeded_and_spread() {
    let random = |seed| sequence(RandomViews { seed }, 0);
    let first = random(1);
    assert_eq!(first, random(1));
    assert_ne!(first, random(2));
    let mut sorted = first.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..60).collect::<Vec<_>>());
    // Second views over many seeds fall on all candidates about equally.
    let mut counts = [0; 60];
    (0..5900).for_each(|seed| counts[next(&mut RandomViews { seed }, &[0]).unwrap()] += 1);
    assert!(counts[1..].iter().all(|&n| (60..150).contains(&n)), "{counts:?}");
}

#[test]
fn in_order_begins_anew_after_the_last_view() {
    assert_eq!(sequence(InOrder, 0), (0..60).collect::<Vec<_>>());
    assert_eq!(sequence(InOrder, 57), [57, 58, 59].into_iter().chain(0..57).collect::<Vec<_>>());
    assert_eq!(next(&mut InOrder, &[]), Some(0));
}

/// The views that a planner takes one after the other until there is none left.
fn sequence(mut planner: impl ViewPlanner, first: usize) -> Vec<usize> {
    let mut visited = vec![first];
    while let Some(view) = next(&mut planner, &visited) {
        visited.push(view);
    }
    visited
}

fn next(planner: &mut dyn ViewPlanner, visited: &[usize]) -> Option<usize> {
    plan(planner, &unknown(), visited).choice.map(|choice| choice.view)
}
