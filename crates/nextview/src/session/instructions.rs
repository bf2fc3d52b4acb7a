//! Whole scans with the baseline instructions and with those of this CPU: all bits are the same.

use super::{Decision, Session, SessionConfig};
use crate::Cancel;
use crate::flow::{Incidence, fewest_sets};
use crate::gain::RearSideEntropy;
use crate::geometry::random::Random;
use crate::geometry::{Aabb, Pose};
use crate::instructions::tests::with_each;
use crate::planner::{
    Batch, BatchConfig, FrontierTour, Greedy, GreedyConfig, MaxFlow, MaxFlowConfig, MostSurface,
    MostSurfaceConfig, PbNbv, See, ViewPlanner,
};
use crate::registration::RegistrationConfig;
use crate::sensor::{DepthImage, Distortion, Frame, Intrinsics};
use crate::view::generate;
use glam::{DVec2, DVec3};

/// A lens whose rays are found iteratively, and one whose pixels are.
fn camera(distortion: Distortion) -> Intrinsics {
    let camera = Intrinsics::pinhole(37, 29, DVec2::splat(34.0), DVec2::new(18.2, 13.9)).unwrap();
    camera.with_distortion(distortion).unwrap()
}

/// A frame of a ball with a smaller one next to it.
fn frame(camera: Intrinsics, pose: Pose) -> Frame {
    let depth = |u: u32, v: u32| {
        let ray = camera.deproject(DVec2::new(u as f64, v as f64)).map(|point| point.extend(1.0))?;
        let along = pose.rotation() * ray;
        let depths = [(DVec3::ZERO, 0.06), (DVec3::new(0.0, 0.05, 0.04), 0.03)].map(|(center, radius)| {
            let to = center - pose.translation();
            let (a, b) = (along.length_squared(), along.dot(to));
            let root = b * b - a * (to.length_squared() - radius * radius);
            if root > 0.0 { (b - root.sqrt()) / a } else { f64::INFINITY }
        });
        Some(depths[0].min(depths[1]) as f32)
    };
    let pixels = (0..camera.height()).flat_map(|v| (0..camera.width()).map(move |u| (u, v)));
    let depths = pixels.map(|(u, v)| depth(u, v).unwrap_or(f32::NAN)).collect();
    let image = DepthImage::from_metres(camera.width(), camera.height(), depths).unwrap();
    Frame::new(image, camera, pose, 1.0).unwrap()
}

/// Every number of a scan, printed in full: different numbers print differently.
fn scan(camera: Intrinsics, planner: Box<dyn ViewPlanner>) -> String {
    let mut config = SessionConfig::new(0.02, Aabb::cube(DVec3::ZERO, 0.2));
    (config.max_views, config.registration) = (4, RegistrationConfig::enabled());
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.35, 24).unwrap();
    let mut session = Session::new(config, camera, views, planner).unwrap();
    let mut numbers = String::new();
    while let Decision::Move(view) = session.decide().unwrap() {
        let report = session.observe(&frame(camera, view.world_from_camera)).unwrap();
        numbers += &format!("{view:?} {report:?} {:?}\n", session.map().voxels());
    }
    assert_eq!(session.visited().len(), 4);
    numbers
}

fn check<T: PartialEq>(computed: Vec<T>, what: &str) {
    assert!(computed.len() > 1 && computed.iter().all(|other| *other == computed[0]), "{what}");
}

fn check_planner(what: &str, planner: impl Fn() -> Box<dyn ViewPlanner>) {
    let k = [0.1, -0.05, 0.002, -0.001, 0.01];
    for lens in [Distortion::BrownConrady(k), Distortion::InverseBrownConrady(k)] {
        check(with_each(|| scan(camera(lens), planner())), what);
    }
}

#[test]
fn scans_have_the_same_bits_with_all_instructions() {
    let greedy = GreedyConfig::default();
    check_planner("most-surface", || Box::new(MostSurface::new(MostSurfaceConfig::default()).unwrap()));
    check_planner("max-flow", || Box::new(MaxFlow::new(MaxFlowConfig::default()).unwrap()));
    check_planner("rse", || Box::new(Greedy::<RearSideEntropy>::new(greedy).unwrap()));
    check_planner("batch", || Box::new(Batch::new(BatchConfig::default()).unwrap()));
    check_planner("frontier-tour", || Box::new(FrontierTour::new(greedy.ray_spacing).unwrap()));
    check_planner("pb-nbv", || Box::new(PbNbv));
    check_planner("see", || Box::new(See::default()));
}

/// Problems that reduction alone cannot solve.
#[test]
fn covers_are_the_same_with_all_instructions() {
    let mut random = Random::new(1, 0);
    for _ in 0..20 {
        let mut row = || (0..4).map(|_| random.range(0.0, 40.0) as u32).collect::<Vec<u32>>();
        let rows: Vec<Vec<u32>> = (0..60).map(|_| row()).collect();
        let candidates = Incidence::from_rows(40, rows);
        check(with_each(|| fewest_sets(&candidates, &Cancel::default()).unwrap()), "cover");
    }
}
