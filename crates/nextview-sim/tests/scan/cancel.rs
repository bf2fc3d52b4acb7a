//! Decisions that are cancelled leave no trace, and views that are skipped do not come back.

use glam::DVec3;
use nextview::geometry::Lattice;
use nextview::geometry::random::Random;
use nextview::map::LogOdds;
use nextview::object::{ObjectBox, Table};
use nextview::planner::{
    Batch, BatchConfig, MaxFlow, MaxFlowConfig, MostSurface, MostSurfaceConfig, RandomViews, ViewPlanner,
};
use nextview::registration::RegistrationConfig;
use nextview::sensor::{Frame, Intrinsics};
use nextview::session::{
    Decision, MultiResolutionConfig, NextView, Session, SessionConfig, StepReport, StopReason, Views,
};
use nextview::surface::{downsample, fit_normals};
use nextview::view::{Reach, generate, look_at};
use nextview::{Cancel, Cancelled};
use nextview_model::{DistanceField, take_nearest};
use nextview_sim::builtin;
use nextview_sim::scene::Scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const VOXEL_SIZE: f64 = 0.01;

fn scene() -> Scene {
    Scene::new(builtin::by_name("mug").unwrap(), Intrinsics::d435i()).unwrap()
}

fn planners() -> [Box<dyn ViewPlanner>; 4] {
    [
        Box::new(MaxFlow::new(MaxFlowConfig::default()).unwrap()),
        Box::new(MostSurface::new(MostSurfaceConfig::default()).unwrap()),
        Box::new(Batch::new(BatchConfig { n_views: 3, tolerance: 0.2, ..BatchConfig::default() }).unwrap()),
        Box::new(Batch::new(BatchConfig { theta: 0.2, ..BatchConfig::default() }).unwrap()),
    ]
}

fn session(scene: &Scene, planner: Box<dyn ViewPlanner>) -> Session {
    let rule = MultiResolutionConfig { coarsest_voxel_size: Some(0.02), q_thresh: 0.3, enabled: true };
    let config = SessionConfig {
        max_views: 5,
        multi_resolution: rule,
        ..SessionConfig::new(VOXEL_SIZE, scene.planning_box(VOXEL_SIZE))
    };
    let views = generate::shell(scene.center(), scene.size(), 300, 1).unwrap();
    Session::new(config, Intrinsics::d435i(), views, planner).unwrap()
}

/// Reports and stop reason of a scan, and the map.
type Outcome = (Vec<StepReport>, StopReason, Vec<(glam::IVec3, LogOdds)>);

fn scan(scene: &Scene, session: &mut Session, mut decide: impl FnMut(&mut Session) -> Decision) -> Outcome {
    let mut reports = Vec::new();
    loop {
        match decide(session) {
            Decision::Move(next) => {
                let frame = scene.camera().capture(&next.world_from_camera).unwrap();
                reports.push(session.observe(&frame).unwrap());
            }
            Decision::Stop(reason) => return (reports, reason, session.map().voxels()),
        }
    }
}

/// Cancels from another thread until a decision is made, each time a little later.
fn decide_under_fire(
    session: &mut Session,
    cancel: &Cancel,
    random: &mut Random,
    n_cancelled: &mut usize,
) -> Decision {
    let mut patience = 1e-4;
    loop {
        let delay = Duration::from_secs_f64(patience * random.unit());
        let decision = std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(delay);
                cancel.cancel();
            });
            session.decide().unwrap()
        });
        cancel.reset();
        match decision {
            Decision::Stop(StopReason::Cancelled) => *n_cancelled += 1,
            decision => return decision,
        }
        patience *= 1.3;
    }
}

#[test]
fn a_cancelled_decision_leaves_no_trace() {
    let (scene, mut random) = (scene(), Random::new(11, 0));
    for (undisturbed, disturbed) in planners().into_iter().zip(planners()) {
        let expected = scan(&scene, &mut session(&scene, undisturbed), |session| session.decide().unwrap());
        let (cancel, mut n_cancelled) = (Cancel::default(), 0);
        let mut session = session(&scene, disturbed).with_cancel(cancel.clone());
        let found = scan(&scene, &mut session, |session| {
            decide_under_fire(session, &cancel, &mut random, &mut n_cancelled)
        });
        assert!(found == expected, "{:?} instead of {:?}", found.0, expected.0);
        assert!(n_cancelled > 10, "{n_cancelled} decisions were cancelled");
    }
}

#[test]
fn a_decision_that_was_made_stays_until_it_is_used() {
    let (scene, cancel) = (scene(), Cancel::default());
    let mut session = session(&scene, Box::new(RandomViews { seed: 1 })).with_cancel(cancel.clone());
    let first = session.decide().unwrap();
    cancel.cancel();
    assert_eq!(session.decide().unwrap(), first);
    let Decision::Move(next) = first else { panic!("a first view") };
    let frame = scene.camera().capture(&next.world_from_camera).unwrap();
    assert_eq!(session.observe(&frame), Err(Cancelled));
    assert!(session.frames().is_empty() && session.visited().is_empty());
    cancel.reset();
    session.observe(&frame).unwrap();
    cancel.cancel();
    assert_eq!(session.decide().unwrap(), Decision::Stop(StopReason::Cancelled));
    cancel.reset();
    assert!(matches!(session.decide().unwrap(), Decision::Move(_)));
}

/// Voxels of 1 mm and 5000 candidates. A cancelled decision ends within 50 ms on an idle machine; the bound
/// leaves room for a busy one.
#[test]
fn cancelling_takes_no_time() {
    let scene = scene();
    let config = SessionConfig::new(0.001, scene.planning_box(0.001));
    let views = generate::shell(scene.center(), scene.size(), 5000, 1).unwrap();
    let frames: Vec<_> = (0..2).map(|view| scene.camera().capture(&views.pose(view)).unwrap()).collect();
    // Threads of their own: those that all tests share may have taken up the long work of another test.
    let threads = rayon::ThreadPoolBuilder::new().build().unwrap();
    for planner in planners() {
        let cancel = Cancel::default();
        let session = Session::new(config, Intrinsics::d435i(), views.clone(), planner).unwrap();
        let mut session = session.with_cancel(cancel.clone());
        session.decide().unwrap();
        frames.iter().for_each(|frame| _ = session.observe(frame).unwrap());
        for delay in [1, 20, 100, 300, 700, 1500] {
            let (decision, late) = std::thread::scope(|scope| {
                let cancelled = scope.spawn(|| {
                    std::thread::sleep(Duration::from_millis(delay));
                    cancel.cancel();
                    Instant::now()
                });
                let decision = threads.install(|| session.decide().unwrap());
                let now = Instant::now();
                (decision, now.saturating_duration_since(cancelled.join().unwrap()))
            });
            cancel.reset();
            println!("cancelled after {delay} ms, ended {late:?} later");
            assert!(late < Duration::from_secs(1), "{late:?}");
            if matches!(decision, Decision::Move(_)) {
                break;
            }
        }
    }
}

/// A session whose box grows and whose voxels are halved, so that maps are rebuilt, with registration.
fn busy_session(scene: &Scene, voxel_size: f64) -> Session {
    let config = SessionConfig {
        object_box: ObjectBox::Growing,
        table: Table::Fitted,
        max_gap: 0.02,
        multi_resolution: MultiResolutionConfig { q_thresh: 0.9, ..MultiResolutionConfig::enabled() },
        registration: RegistrationConfig::enabled(),
        ..SessionConfig::new(voxel_size, scene.planning_box(voxel_size))
    };
    let unit = generate::shell(DVec3::ZERO, 1.0, 100, 1).unwrap();
    let first = look_at(scene.center() + DVec3::new(0.3, 0.2, 0.4), scene.center()).unwrap();
    let views = Views::Following { first, unit, reach: Arc::new(Reach::default().within(scene.room())) };
    let planner = Box::new(RandomViews { seed: 1 });
    Session::new(config, Intrinsics::d435i(), views, planner).unwrap()
}

/// Frames of a scan of this scene.
fn frames(scene: &Scene, n: usize) -> Vec<Frame> {
    let views = generate::hemisphere(scene.center(), 3.0 * scene.size(), n).unwrap();
    views.poses().iter().map(|pose| scene.camera().capture(pose).unwrap()).collect()
}

#[test]
fn a_cancelled_observation_leaves_no_trace() {
    let (scene, mut random) = (scene().with_table().unwrap(), Random::new(5, 0));
    let (mut undisturbed, cancel) = (busy_session(&scene, VOXEL_SIZE), Cancel::default());
    let mut disturbed = busy_session(&scene, VOXEL_SIZE).with_cancel(cancel.clone());
    let mut n_cancelled = 0;
    for frame in frames(&scene, 5) {
        let expected = undisturbed.observe(&frame).unwrap();
        let mut patience = 1e-3;
        let found = loop {
            let delay = Duration::from_secs_f64(patience * random.unit());
            let report = std::thread::scope(|scope| {
                scope.spawn(|| {
                    std::thread::sleep(delay);
                    cancel.cancel();
                });
                disturbed.observe(&frame)
            });
            cancel.reset();
            match report {
                Ok(report) => break report,
                Err(Cancelled) => n_cancelled += 1,
            }
            patience *= 1.3;
        };
        assert_eq!(found, expected);
        assert_eq!(disturbed.map().voxels(), undisturbed.map().voxels());
        assert_eq!(disturbed.views(), undisturbed.views());
        assert_eq!(disturbed.other_bodies().unwrap(), undisturbed.other_bodies().unwrap());
    }
    assert!(n_cancelled > 10, "{n_cancelled} observations were cancelled");
}

/// Voxels of 1 mm. A cancelled observation ends within 50 ms on an idle machine; the bound leaves room for a
/// busy one.
#[test]
fn cancelling_an_observation_or_the_model_takes_no_time() {
    // Threads of its own, as above.
    rayon::ThreadPoolBuilder::new().build().unwrap().install(cancel_observations_and_models);
}

fn cancel_observations_and_models() {
    let scene = scene().with_table().unwrap();
    let (cancel, frames) = (Cancel::default(), frames(&scene, 4));
    let mut session = busy_session(&scene, 0.001).with_cancel(cancel.clone());
    let late = |what: &str, delay: u64, work: &mut dyn FnMut() -> bool| {
        let is_over = AtomicBool::new(false);
        let is_done = std::thread::scope(|scope| {
            let cancelled = scope.spawn(|| {
                let start = Instant::now();
                while start.elapsed() < Duration::from_millis(delay) && !is_over.load(Ordering::Relaxed) {
                    std::thread::sleep(Duration::from_millis(1));
                }
                cancel.cancel();
                Instant::now()
            });
            let is_done = work();
            let now = Instant::now();
            is_over.store(true, Ordering::Relaxed);
            let late = now.saturating_duration_since(cancelled.join().unwrap());
            println!("{what}: cancelled after {delay} ms, ended {late:?} later");
            assert!(late < Duration::from_secs(1), "{what}: {late:?}");
            is_done
        });
        cancel.reset();
        is_done
    };
    for frame in &frames {
        // The last delay is long enough for a busy machine.
        let mut delays = [1, 10, 30, 60, 100, 200, 400, 800, 60_000].into_iter();
        assert!(delays.any(|delay| late("observation", delay, &mut || session.observe(frame).is_ok())));
    }
    let bounds = session.bounds().unwrap();
    let detail = bounds.longest_side() / 128.0;
    let lattice = Lattice::new(detail).unwrap();
    let block = lattice.block_inside(&bounds).unwrap();
    let points = session.frames().iter().flat_map(|frame| frame.points_in(bounds));
    let cloud = downsample(points, detail).unwrap();
    for delay in [1, 10, 30, 60, 100, 200, 400] {
        late("distance field", delay, &mut || {
            let mut field = DistanceField::new(lattice, block, 2.0 * detail).unwrap();
            let integrated = session.frames().iter().try_for_each(|frame| field.integrate(frame, &cancel));
            integrated.and_then(|()| field.surface(&cancel)).is_ok()
        });
        late("normals", delay, &mut || fit_normals(&mut cloud.clone(), detail, &cancel).is_ok());
        late("colours", delay, &mut || take_nearest(&mut cloud.clone(), &cloud, detail, &cancel).is_ok());
    }
}

fn number(decision: &Decision) -> Option<usize> {
    match decision {
        Decision::Move(NextView { view, .. }) => *view,
        Decision::Stop(_) => None,
    }
}

#[test]
fn a_skipped_view_is_never_proposed_again() {
    let scene = scene();
    for planner in planners() {
        let mut session = session(&scene, planner);
        let mut skipped = Vec::new();
        let (reports, ..) = scan(&scene, &mut session, |session| {
            let rejected = session.decide().unwrap();
            if let Some(view) = number(&rejected).filter(|_| skipped.len() < 8) {
                session.skip(view);
                skipped.push(view);
                assert_ne!(number(&session.decide().unwrap()), Some(view));
            }
            session.decide().unwrap()
        });
        assert!(skipped.len() >= 4 && reports.iter().all(|report| !skipped.contains(&report.view.unwrap())));
    }
}

#[test]
fn instead_of_a_skipped_first_view_the_next_number_comes() {
    let scene = scene();
    let config =
        SessionConfig { first_view: 8, ..SessionConfig::new(VOXEL_SIZE, scene.planning_box(VOXEL_SIZE)) };
    let views = generate::shell(scene.center(), scene.size(), 10, 1).unwrap();
    let far = views.pose(9).translation();
    let views = views.restricted(|position| position != far);
    let planner = Box::new(RandomViews { seed: 1 });
    let mut session = Session::new(config, Intrinsics::d435i(), views, planner).unwrap();
    assert_eq!(number(&session.decide().unwrap()), Some(8));
    session.skip(8);
    assert_eq!(number(&session.decide().unwrap()), Some(0), "9 is out of reach");
    session.skip(1);
    session.skip(0);
    assert_eq!(number(&session.decide().unwrap()), Some(2));
    (0..10).for_each(|view| session.skip(view));
    assert!(matches!(session.decide().unwrap(), Decision::Stop(_)), "no view is left");
}

#[test]
fn a_skipped_candidate_stays_skipped_when_the_box_grows() {
    let scene = scene().with_table().unwrap();
    let config = SessionConfig {
        object_box: ObjectBox::Growing,
        table: Table::Fitted,
        multi_resolution: MultiResolutionConfig::enabled(),
        ..SessionConfig::new(VOXEL_SIZE, scene.planning_box(VOXEL_SIZE))
    };
    let unit = generate::shell(DVec3::ZERO, 1.0, 200, 1).unwrap();
    let first = look_at(scene.center() + DVec3::new(0.3, 0.2, 0.4), scene.center()).unwrap();
    let views = Views::Following { first, unit, reach: Arc::new(Reach::default().within(scene.room())) };
    let planner = Box::new(MaxFlow::new(MaxFlowConfig::default()).unwrap());
    let mut session = Session::new(config, Intrinsics::d435i(), views, planner).unwrap();
    let (mut skipped, mut boxes) = (Vec::new(), Vec::new());
    let (reports, ..) = scan(&scene, &mut session, |session| {
        boxes.extend(session.bounds());
        for _ in 0..2 {
            if let Some(view) = number(&session.decide().unwrap()) {
                session.skip(view);
                skipped.push(view);
            }
        }
        session.decide().unwrap()
    });
    boxes.dedup();
    assert!(boxes.len() > 1, "the box grew");
    assert!(
        skipped.len() > 3
            && reports.iter().filter_map(|report| report.view).all(|view| !skipped.contains(&view))
    );
}
