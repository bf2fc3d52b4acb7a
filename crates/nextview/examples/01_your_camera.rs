//! A scan with a camera of your own: here, one that sees a ball. Afterwards, the cloud is compared with the
//! ball.

use nextview::Error;
use nextview::geometry::{Aabb, Pose};
use nextview::glam::{DVec2, DVec3};
use nextview::object::planning_box;
use nextview::planner::{MostSurface, MostSurfaceConfig};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{Decision, Session, SessionConfig, StopConfig, StopReason};
use nextview::surface::{downsample, frame_points};
use nextview::view::generate;

const RADIUS: f64 = 0.08;
const VOXEL_SIZE: f64 = 0.01;

fn main() -> Result<(), Error> {
    let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5))?;
    let bounds = planning_box(&Aabb::cube(DVec3::ZERO, RADIUS), VOXEL_SIZE);
    let stop = StopConfig { completeness: Some(0.9), ..StopConfig::default() };
    let config = SessionConfig { max_views: 20, stop, ..SessionConfig::new(VOXEL_SIZE, bounds) };
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.35, 200)?;
    let planner = MostSurface::new(MostSurfaceConfig::default())?;
    let mut session = Session::new(config, camera, views, Box::new(planner))?;

    let reason = loop {
        match session.decide()? {
            Decision::Move(next) => {
                let report = session.observe(&capture(&camera, &next.world_from_camera)?)?;
                println!("view {:?}: {} new voxels", report.view, report.update.n_newly_occupied);
            }
            Decision::Stop(reason) => break reason,
        }
    };

    println!("{reason:?} after {} views", session.visited().len());
    assert!(matches!(reason, StopReason::Complete | StopReason::NothingToGain));
    let mut points = Vec::new();
    for frame in session.frames() {
        points.extend(frame_points(frame, None, bounds)?);
    }
    let cloud = downsample(points, 0.005)?;
    let is_on_ball = |point: DVec3| (point.length() - RADIUS).abs() < 1e-3;
    assert!(cloud.len() > 1000 && cloud.iter().all(|point| is_on_ball(point.position)));
    Ok(())
}

/// What a depth camera sees of a ball of 8 cm at the origin: the nearer solution of a quadratic equation for
/// every pixel.
fn capture(camera: &Intrinsics, world_from_camera: &Pose) -> Result<Frame, Error> {
    let position = world_from_camera.translation();
    let depth = |pixel: u32| {
        let pixel = DVec2::new((pixel % camera.width()) as f64, (pixel / camera.width()) as f64);
        let Some(ideal) = camera.deproject(pixel) else { return f32::NAN };
        let ray = world_from_camera.rotation() * ideal.extend(1.0);
        let (a, b) = (ray.length_squared(), ray.dot(position));
        let root = b * b - a * (position.length_squared() - RADIUS * RADIUS);
        if root > 0.0 { ((-b - root.sqrt()) / a) as f32 } else { f32::INFINITY }
    };
    let depth = (0..camera.n_pixels() as u32).map(depth).collect();
    let image = DepthImage::from_metres(camera.width(), camera.height(), depth)?;
    Frame::new(image, *camera, *world_from_camera, 2.0)
}
