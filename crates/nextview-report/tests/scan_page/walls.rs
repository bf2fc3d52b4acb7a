//! A scan by a session whose camera sees walls.

use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::planner::InOrder;
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{NextView, Session, SessionConfig};
use nextview::view::generate;
use nextview_report::live::{LiveScene, SceneSource};
use nextview_scan::{Next, ScanConfig, ScanRun, ScanState};
use serde_json::Value;

/// A scan in which every camera looks at the middle of a box from 0.4 m and sees a wall there.
pub fn walls(n_views: usize) -> (ScanState<'static>, Option<NextView>, Aabb) {
    let camera = Intrinsics::d435i();
    let bounds = Aabb::cube(DVec3::ZERO, 0.1);
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, n_views + 1).unwrap();
    let config = SessionConfig::new(0.01, bounds);
    let mut run = ScanRun::new(Session::new(config, camera, views, Box::new(InOrder)).unwrap());
    for pushes in 0..n_views {
        let Next::Capture(view) = run.next().unwrap() else { panic!("stopped after {pushes} views") };
        let image = DepthImage::from_metres(640, 480, vec![0.4; camera.n_pixels()]).unwrap();
        let frame = Frame::new(image, camera, view.world_from_camera, 1.0).unwrap();
        run.push(frame).unwrap();
    }
    let next = match run.next().unwrap() {
        Next::Capture(view) => Some(view),
        _ => None,
    };
    (run.finish(None), next, bounds)
}

/// The live scene of that scan, with the views after number `after`.
pub fn scene(n_views: usize, after: usize) -> Value {
    let (scan, next, _) = walls(n_views);
    let text = LiveScene::default().json(&SceneSource::of_scan(&scan, &ScanConfig::default(), next), after);
    assert!(text.len() < 300_000, "{} bytes", text.len());
    serde_json::from_str(&text).unwrap()
}
