//! A scan: odd configurations, odd frames, odd poses, every planner.

#![no_main]

use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use nextview::geometry::Aabb;
use nextview::object::{ObjectBox, Table};
use nextview::planner::ViewPlanner;
use nextview::registration::{RegistrationConfig, RegistrationMode};
use nextview::sensor::{DepthImage, Frame};
use nextview::session::{Decision, Session, SessionConfig};
use nextview::view::generate;
use nextview_fuzz::{Source, lens};
use nextview_scan::{Named, PlannerName, ScanConfig};

/// Metres; most are those of a thing in the box.
fn depth(byte: u8) -> f32 {
    match byte {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => 1e-30,
        3 => 1e30,
        4 => -1.0,
        5 => 0.0,
        plain => f32::from(plain) * 0.004,
    }
}

fn planner(source: &mut Source<'_>) -> Option<Box<dyn ViewPlanner>> {
    let name = source.pick(PlannerName::ALL);
    // Networks take a hundred times as long as all others.
    let is_quick = !name.properties().is_network;
    let config = ScanConfig { planner: name.into(), seed: 7, ..ScanConfig::default() };
    is_quick.then(|| config.planner(None).ok()).flatten()
}

fn config(source: &mut Source<'_>) -> SessionConfig {
    let center = if source.byte() % 8 == 0 { source.vector() } else { DVec3::ZERO };
    let voxel_size = source.pick(&[0.06, 0.05, 0.08, 0.04, 1e-4, 1e6, f64::NAN, 0.0]);
    let mut config = SessionConfig::new(voxel_size, Aabb::cube(center, 0.2));
    config.memory_limit_mb = 8;
    if source.byte() % 3 == 0 {
        config.object_box = ObjectBox::Growing;
    }
    config.table = source.pick(&[Table::None, Table::Fitted, Table::AtHeight(-0.1), Table::AtHeight(0.3)]);
    let modes = [RegistrationMode::Off, RegistrationMode::On, RegistrationMode::Auto];
    config.registration.enabled = Some(source.pick(&modes));
    if source.byte() % 8 == 0 {
        config.registration = RegistrationConfig { spacing: Some(source.number()), ..config.registration };
    }
    config.max_views = 1 + usize::from(source.byte() % 5);
    config.goal = (source.byte() % 4 == 0).then(|| source.number());
    config.max_gap = if source.byte() % 8 == 0 { source.number() } else { 0.0 };
    config
}

fuzz_target!(|bytes: &[u8]| {
    let mut source = Source(bytes);
    let (Some(planner), config, Some(camera)) =
        (planner(&mut source), config(&mut source), lens(&mut source))
    else {
        return;
    };
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 6).expect("six views");
    let Ok(mut session) = Session::new(config, camera, views, planner) else { return };
    for _ in 0..4 {
        if source.is_empty() {
            break;
        }
        let next = session.decide().expect("planners of the library cannot fail");
        let proposed = match &next {
            Decision::Move(view) if source.byte() % 4 > 0 => Some(view.world_from_camera),
            _ => source.pose(),
        };
        let Some(pose) = proposed else { continue };
        // Whole rows alike, or each pixel its own.
        let (is_plain, row) = (source.byte() % 2 == 0, source.byte());
        let depths =
            (0..camera.n_pixels()).map(|_| depth(if is_plain { row } else { source.byte() })).collect();
        let Ok(image) = DepthImage::from_metres(camera.width(), camera.height(), depths) else { continue };
        let range = source.pick(&[1.0, 0.5, 1e-3, 1e9]);
        let Ok(frame) = Frame::new(image, camera, pose, range) else { continue };
        let _ = session.locate(&frame).expect("nobody cancels");
        session.observe(&frame).expect("nobody cancels");
        let _ = (session.suspicion(), session.other_bodies(), session.frames_of_object());
    }
    // Asked for once, at the end of a scan: it tries thousands of directions.
    if source.byte() % 32 == 1 {
        let _ = session.next_placement();
    }
    let _ = session.decide().expect("planners of the library cannot fail");
});
