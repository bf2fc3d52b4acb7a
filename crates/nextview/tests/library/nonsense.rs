//! The public interface, given nonsense: not a number, infinite, huge, tiny, zero, nothing. It returns errors
//! or answers, without a panic and within bounds of time and memory.

#![allow(clippy::unwrap_used, reason = "helpers of a test")]

use glam::{DQuat, DVec2, DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::gain::ProximityCount;
use nextview::geometry::{Aabb, Lattice, Plane, Pose, SegmentWalk, VoxelBlock, fit_ground};
use nextview::map::{Background, Integration, LogOdds, OccupancyMap, RayRule, SensorModel, Snapshot};
use nextview::motion::{
    KeepOut, MotionConfig, SpeedProfile, Surroundings, Trajectory, detour, tour, tour_length,
};
use nextview::object::{ObjectBox, Table};
use nextview::planner::{
    Batch, BatchConfig, Greedy, GreedyConfig, InOrder, MaxFlow, MaxFlowConfig, MinOverlap, MostSurface,
    MostSurfaceConfig, RandomViews, Situation, ViewPlanner,
};
use nextview::registration::{KnownSurface, RegistrationConfig, RegistrationMode};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{Decision, Session, SessionConfig, Views};
use nextview::surface::{CloudPoint, downsample, fit_normals};
use nextview::view::{Reach, ViewSpace, generate, look_at};
use nextview::visibility::{FreeSpace, RayCaster};
use proptest::prelude::*;
use std::sync::Arc;

/// A number that nobody means, or a plain one.
fn number() -> impl Strategy<Value = f64> {
    let nonsense = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        1e300,
        -1e300,
        1e30,
        1e9,
        -1e8,
        1e4,
        0.0,
        -0.0,
        f64::MIN_POSITIVE,
        1e-300,
        1e-9,
    ];
    prop_oneof![2 => prop::sample::select(nonsense.to_vec()), 1 => -1.0..1.0]
}

/// A number that may be a size.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![1 => number(), 1 => 0.001..0.1]
}

fn vector() -> impl Strategy<Value = DVec3> {
    (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// A vector that is often a place.
fn place() -> impl Strategy<Value = DVec3> {
    let plain = prop::array::uniform3(-0.5..0.5).prop_map(DVec3::from_array);
    prop_oneof![2 => vector(), 1 => plain]
}

fn key() -> impl Strategy<Value = IVec3> {
    let number = prop::sample::select(vec![i32::MIN, i32::MAX, 0, -1, 1 << 28, -(1 << 30), 40_000]);
    prop::array::uniform3(number).prop_map(IVec3::from_array)
}

fn camera() -> Intrinsics {
    Intrinsics::pinhole(24, 18, DVec2::splat(20.0), DVec2::new(11.5, 8.5)).unwrap()
}

/// A frame from a place where cameras can stand.
fn frame() -> impl Strategy<Value = Frame> {
    let pose =
        (place(), place()).prop_filter_map("a pose", |(position, target)| look_at(position, target).ok());
    let depth = prop::collection::vec(number().prop_map(|x| x as f32), 24 * 18);
    let near =
        prop::array::uniform3(-0.5..0.5).prop_map(|p| look_at(DVec3::from_array(p), DVec3::ZERO).unwrap());
    (prop_oneof![pose, near], depth, size()).prop_filter_map("a frame", |(pose, depth, range)| {
        Frame::new(DepthImage::from_metres(24, 18, depth).ok()?, camera(), pose, range).ok()
    })
}

fn snapshot() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    Snapshot::from_fn(Lattice::new(0.02).unwrap(), block, |key| match key.x {
        0 => Some(LogOdds(0.8)),
        1.. => Some(LogOdds(-0.4)),
        _ => None,
    })
}

fn planners() -> Vec<Box<dyn ViewPlanner>> {
    vec![
        Box::new(MaxFlow::new(MaxFlowConfig::default()).unwrap()),
        Box::new(MostSurface::new(MostSurfaceConfig::default()).unwrap()),
        Box::new(Batch::new(BatchConfig { theta: 0.2, ..BatchConfig::default() }).unwrap()),
        Box::new(Greedy::<ProximityCount>::new(GreedyConfig::default()).unwrap()),
        Box::new(MinOverlap::new(0.3, Box::new(InOrder)).unwrap()),
        Box::new(RandomViews { seed: 1 }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn geometry(a in vector(), b in vector(), c in vector(), x in number(), key in key(), dims in key()) {
        let rotation = DQuat::from_xyzw(a.x, a.y, a.z, b.x);
        if let Ok(pose) = Pose::new(rotation, c) {
            prop_assert!(pose.translation().is_finite() && pose.inverse().translation().is_finite());
        }
        if let Ok(pose) = look_at(a, b) {
            prop_assert!(pose.translation().is_finite() && pose.rotation().is_finite());
        }
        let bounds = Aabb { min: a, max: b };
        let _ = (bounds.check(), bounds.center(), bounds.clip(a, b, x), bounds.contains(c), bounds.corners());
        if let Ok(plane) = Plane::new(a, b) {
            let _ = plane.height(c);
        }
        if let Ok(lattice) = Lattice::new(x.abs()) {
            let _ = (lattice.key(a), lattice.center(key), lattice.keys_inside(&bounds));
            if let Some(block) = lattice.block_inside(&bounds) {
                let _ = (lattice.bounds(&block), block.index(key), block.key(block.n_voxels() - 1));
            }
        }
        let dims = dims.as_uvec3();
        if let Some(block) = VoxelBlock::new(key, dims) {
            prop_assert!(block.index(block.max()) == Some(block.n_voxels() - 1));
            prop_assert!(block.neighbors(0).count() <= 7);
        }
        let (low, high) = (IVec3::splat(-3), IVec3::splat(4));
        for walk in [SegmentWalk::within(a, b, low, high), SegmentWalk::ray_within(a, b, low, high)] {
            let Some(mut walk) = walk else { continue };
            let mut n = 0;
            while walk.advance().is_some() {
                n += 1;
                prop_assert!(n < 30, "more steps than the block has");
            }
        }
        let _ = fit_ground(&[a, b, c, a], b);
    }

    #[test]
    fn views(center in place(), target in place(), size in size(), n in 0_usize..20, seed: u64) {
        let all = [
            generate::shell(center, size, n, seed),
            generate::fibonacci_sphere(center, size, n),
            generate::hemisphere(center, size, n),
        ];
        for views in all.into_iter().flatten() {
            prop_assert!(views.len() == n && views.poses().iter().all(|pose| pose.translation().is_finite()));
            if let Ok(moved) = views.around(target, size) {
                prop_assert!(moved.poses().iter().all(|pose| pose.translation().is_finite()));
            }
        }
        let text = format!("{},{},{}\n{size},0,0\n", center.x, center.y, center.z);
        let _ = ViewSpace::read_csv(text.as_bytes(), target);
    }

    #[test]
    fn motion(a in place(), b in place(), c in place(), x in size(), y in size()) {
        let config = MotionConfig { speed: x, acceleration: y, clearance: x, sensing_time: y };
        let bounds = Aabb { min: c.min(b), max: c.max(b) };
        for config in [config, MotionConfig::default()] {
            for object in [None, Some(bounds), Some(Aabb { min: c, max: b })] {
                let floor = Plane::new(b, c).ok();
                let around = Surroundings { object, floor };
                let (Ok(from), Ok(to)) = (look_at(a, b), look_at(b, c)) else { continue };
                if let Ok(trajectory) = Trajectory::new(&from, &to, &around, &config) {
                    prop_assert!(trajectory.length().is_finite() && trajectory.duration().is_finite());
                    prop_assert!(trajectory.waypoints().len() < 100_000);
                }
            }
        }
        if let Ok(ball) = KeepOut::new(a, x, y) {
            let _ = (ball.path(b, c).len(), ball.path_length(b, c), tour_length(Some(a), [b, c], &ball));
            let _ = detour(Some(a), &[b, c], a, &ball);
            for n in [0, 1, 3, 13] {
                let positions: Vec<DVec3> = [a, b, c, DVec3::X].into_iter().cycle().take(n).collect();
                if let Ok(mut order) = tour(Some(c), &positions, &ball) {
                    order.sort_unstable();
                    prop_assert_eq!(order, (0..n).collect::<Vec<_>>());
                }
            }
        }
        let profile = SpeedProfile::new(x, y, x);
        let _ = (profile.duration(), profile.distance_at(y), profile.time_at(y));
    }

    #[test]
    fn maps(points in prop::collection::vec(place(), 0..20), origin in place(), x in size(), per_end: bool, carves: bool) {
        // A scan just within its bounds would take gigabytes and minutes. Points that are not finite are left
        // out of it, whatever the others are.
        let finite = points.iter().filter(|point| point.is_finite());
        let n_crossings: f64 = finite.map(|point| point.distance(origin) / x).sum();
        prop_assume!(!(1e5..1e12).contains(&n_crossings));
        let Ok(lattice) = Lattice::new(x) else { return Ok(()) };
        let rays = if per_end { RayRule::OnePerEndVoxel } else { RayRule::EveryPoint };
        let background = if carves { Background::Carve } else { Background::Ignore };
        let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(9)).unwrap();
        for region in [None, Some(block)] {
            let mut map = OccupancyMap::new(lattice, SensorModel::default()).unwrap();
            let integration = Integration { rays, background, region, ..Integration::default() };
            match map.integrate_points(&points, origin, &integration) {
                Ok(update) => prop_assert_eq!(update.n_first_measured, map.voxels().len()),
                Err(_) => prop_assert!(map.voxels().is_empty()),
            }
            let _ = (map.snapshot(block).entropy(), map.coarser(3).is_ok());
        }
    }

    #[test]
    fn surfaces(points in prop::collection::vec((place(), vector()), 0..20), cell in size(), frame in frame()) {
        let never = &Cancel::default();
        let cloud = points.iter().map(|(position, normal)| CloudPoint {
            normal: normal.try_normalize(),
            color: Some([1, 2, 3]),
            ..CloudPoint::from(*position)
        });
        if let Ok(mut cloud) = downsample(cloud, cell) {
            fit_normals(&mut cloud, cell, never).unwrap();
        }
        let mut known = KnownSurface::new(RegistrationConfig::enabled()).unwrap();
        let bounds = Aabb::cube(DVec3::ZERO, 0.1);
        known.add(&frame, &frame.world_from_camera(), bounds, never).unwrap();
        let found = known.register(&frame, bounds, never).unwrap();
        prop_assert!(found.world_from_camera.translation().is_finite());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn rays(position in place(), target in place(), spacing in size(), corner in place(), half in size()) {
        let snapshot = snapshot();
        let Ok(pose) = look_at(position, target) else { return Ok(()) };
        if let Ok(caster) = RayCaster::new(&snapshot, &camera(), spacing, FreeSpace::Clear) {
            let mut n_rays = 0;
            caster.cast(&pose, |_| n_rays += 1);
            prop_assert!(n_rays <= 1 << 22);
        }
        let grid = nextview::visibility::RayGrid::new(&camera());
        let n = grid.directions(&pose, &Aabb::cube(corner, half), spacing).take((1 << 22) + 1).count();
        prop_assert!(n <= 1 << 22);
    }

    #[test]
    fn planners_in_any_situation(
        places in prop::collection::vec((place(), place()), 1..12), visited in prop::collection::vec(0_usize..14, 0..4),
        finest in size(), frames in prop::collection::vec(frame(), 0..3),
    ) {
        let poses: Vec<Pose> = places.iter().filter_map(|(from, to)| look_at(*from, *to).ok()).collect();
        let Ok(views) = ViewSpace::new(poses) else { return Ok(()) };
        let (snapshot, camera, cancel) = (snapshot(), camera(), Cancel::default());
        let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_frames(&frames);
        let is_known = visited.iter().all(|view| *view < views.len());
        prop_assert_eq!(situation.with_visited(&visited).is_ok(), is_known);
        let situation = situation.with_visited(&visited).unwrap_or(situation);
        let situation = situation.with_finest_voxel_size(finest).unwrap_or(situation);
        for mut planner in planners() {
            let plan = planner.plan(&situation).unwrap();
            prop_assert!(plan.choice.is_none_or(|choice| situation.open_views().contains(&choice.view)));
        }
    }

    #[test]
    fn sessions_of_any_frames(
        frames in prop::collection::vec(frame(), 1..4), x in size(), corner in place(), other in place(),
        grows: bool, fits: bool, memory in prop::sample::select(vec![1_u64, 400]),
        mode in prop::option::of(prop::sample::select(vec![RegistrationMode::Auto, RegistrationMode::On])),
    ) {
        let object_box = match grows {
            true => ObjectBox::Growing,
            false => ObjectBox::Known(Aabb { min: corner.min(other), max: corner.max(other) }),
        };
        let config = SessionConfig {
            object_box,
            max_gap: if fits { 0.05 } else { 0.0 },
            table: if fits { Table::Fitted } else { Table::AtHeight(corner.z) },
            memory_limit_mb: memory,
            registration: RegistrationConfig { enabled: mode, ..RegistrationConfig::default() },
            ..SessionConfig::new(x, Aabb::cube(DVec3::ZERO, 0.1))
        };
        let unit = generate::shell(DVec3::ZERO, 1.0, 20, 1).unwrap();
        let views = match grows {
            true => Views::Following { first: unit.pose(0), unit, reach: Arc::new(Reach::default()) },
            false => unit.into(),
        };
        let planner = RandomViews { seed: 1 };
        let Ok(mut session) = Session::new(config, camera(), views, Box::new(planner)) else { return Ok(()) };
        for frame in &frames {
            if let Decision::Move(next) = session.decide().unwrap() {
                prop_assert!(session.trajectory_to(&next.world_from_camera).is_ok());
            }
            let report = session.observe(frame).unwrap();
            prop_assert!(report.map.entropy.is_finite());
            let _ = (session.other_bodies().unwrap(), session.decide().unwrap());
        }
    }

    #[test]
    fn configurations(x in number(), y in number(), n in 0_usize..3) {
        let _ = MaxFlow::new(MaxFlowConfig { gamma: x, ray_spacing: y, theta: x, ..MaxFlowConfig::default() });
        let _ = MostSurface::new(MostSurfaceConfig { rays_across: x, theta: y, per_second: x < 0.5 });
        let config = BatchConfig { n_views: n, theta: x, least_share: y, tolerance: x, ray_spacing: y };
        let _ = Batch::new(config);
        let config = MaxFlowConfig { ray_spacing: x.abs().min(1.0), ..MaxFlowConfig::default() };
        if let Ok(mut planner) = MaxFlow::new(config) {
            let (snapshot, camera, cancel) = (snapshot(), camera(), Cancel::default());
            let views = generate::shell(DVec3::ZERO, 0.1, 5, 1).unwrap();
            planner.plan(&Situation::new(&snapshot, &views, &camera, &cancel)).unwrap();
        }
    }
}

/// One long ray that would touch more bricks than fit into memory is refused while they are counted.
#[test]
fn a_ray_across_the_lattice_is_refused_at_once() {
    let mut map = OccupancyMap::new(Lattice::new(0.001).unwrap(), SensorModel::default()).unwrap();
    let begin = std::time::Instant::now();
    let far = map.integrate_points(&[DVec3::splat(2e5)], DVec3::ZERO, &Integration::default());
    assert!(matches!(far, Err(nextview::Error::TooLarge { .. })), "{far:?}");
    assert!(map.voxels().is_empty() && begin.elapsed().as_secs() < 30);
}
