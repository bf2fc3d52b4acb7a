//! Scans a ball with a camera function of one's own. Killed at any moment and started again, it resumes the
//! scan and asks for no view twice.

use nextview::geometry::{Aabb, Pose};
use nextview::glam::{DVec2, DVec3};
use nextview::planner::{MostSurface, MostSurfaceConfig};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{Session, SessionConfig};
use nextview::view::generate;
use nextview_scan::{Interrupted, Next, ScanJournal, ScanRun};
use std::error::Error;
use std::path::Path;

const RADIUS: f64 = 0.1;

/// Your camera: takes an image from this pose. This one looks at a ball of 0.2 m.
fn take_image(camera: &Intrinsics, world_from_camera: &Pose) -> Result<Frame, Box<dyn Error>> {
    let eye = world_from_camera.translation();
    let depth = |u: u32, v: u32| {
        let in_camera = ((DVec2::new(u.into(), v.into()) - DVec2::new(79.5, 59.5)) / 150.0).extend(1.0);
        let ray = world_from_camera.rotation() * in_camera;
        let (a, b, c) = (ray.dot(ray), eye.dot(ray), eye.dot(eye) - RADIUS * RADIUS);
        let root = b * b - a * c;
        if root > 0.0 { ((-b - root.sqrt()) / a) as f32 } else { f32::INFINITY }
    };
    let pixels = (0..120).flat_map(|v| (0..160).map(move |u| (u, v))).map(|(u, v)| depth(u, v)).collect();
    Ok(Frame::new(DepthImage::from_metres(160, 120, pixels)?, *camera, *world_from_camera, 2.0)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let dir = Path::new("own-scan");
    let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5))?;
    let config = SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.12));
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 200)?;
    let planner = Box::new(MostSurface::new(MostSurfaceConfig::default())?);
    let session = Session::new(config, camera, views, planner)?;

    let journal = match ScanJournal::is_in(dir) {
        true => ScanJournal::resume(dir).map(|Interrupted { journal, .. }| journal)?,
        false => ScanJournal::begin(dir, "a ball")?,
    };
    let mut run = ScanRun::new(session).with_journal(journal);
    loop {
        match run.next()? {
            Next::Replay(frame) => _ = run.push(frame)?,
            Next::Capture(view) => {
                println!("asked for view {}", view.view.ok_or("all views are candidates")?);
                run.push(take_image(&camera, &view.world_from_camera)?)?;
            }
            Next::Stop(reason) => {
                println!("stopped: {reason:?} after {} views", run.steps().len());
                run.finish(Some(reason)).forget_journal();
                return Ok(());
            }
        }
    }
}
