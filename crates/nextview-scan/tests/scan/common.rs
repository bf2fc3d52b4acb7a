//! A folder to work in, and a ball in front of a user's camera.

use glam::{DVec2, DVec3};
use nextview::geometry::{Aabb, Pose};
use nextview::planner::{MaxFlow, MaxFlowConfig};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{NextView, Session, SessionConfig};
use nextview::view::generate;
use std::fs;
use std::path::{Path, PathBuf};

/// A fresh folder, removed at the end unless the test fails.
pub struct Folder(PathBuf);

impl Folder {
    /// The name must differ from those of all other tests of this crate.
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_PKG_NAME")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = fs::remove_dir_all(&self.0);
        }
    }
}

pub fn camera() -> Intrinsics {
    Intrinsics::pinhole(80, 60, DVec2::splat(75.0), DVec2::new(39.5, 29.5)).unwrap()
}

/// The paper's planner, which remembers its decisions, around a ball of 0.2 m.
pub fn session() -> Session {
    let config = SessionConfig { max_views: 8, ..SessionConfig::new(0.02, Aabb::cube(DVec3::ZERO, 0.12)) };
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 40).unwrap();
    Session::new(config, camera(), views, Box::new(MaxFlow::new(MaxFlowConfig::default()).unwrap())).unwrap()
}

/// An image of the ball from this pose.
pub fn image_from(world_from_camera: &Pose) -> Frame {
    let eye = world_from_camera.translation();
    let depth = |u: u32, v: u32| {
        let in_camera = ((DVec2::new(u.into(), v.into()) - DVec2::new(39.5, 29.5)) / 75.0).extend(1.0);
        let ray = world_from_camera.rotation() * in_camera;
        let (a, b, c) = (ray.dot(ray), eye.dot(ray), eye.dot(eye) - 0.01);
        let root = b * b - a * c;
        if root > 0.0 { ((-b - root.sqrt()) / a) as f32 } else { f32::INFINITY }
    };
    let pixels = (0..60).flat_map(|v| (0..80).map(move |u| (u, v))).map(|(u, v)| depth(u, v)).collect();
    let image = DepthImage::from_metres(80, 60, pixels).unwrap();
    Frame::new(image, camera(), *world_from_camera, 2.0).unwrap()
}

/// An image of the ball of this view.
pub fn image(view: &NextView) -> Frame {
    image_from(&view.world_from_camera)
}

/// The folder of meshes in the reference data. Without it, says which test is skipped.
pub fn meshes(test: &str) -> Option<PathBuf> {
    nextview_checks::data(test, "meshes")
}
