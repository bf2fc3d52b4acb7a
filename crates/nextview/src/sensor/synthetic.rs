//! Synthetic frames for tests, here and in `nextview-model`.

use super::{DepthImage, Frame, Intrinsics, Pose};
use glam::DVec2;

/// A frame of a ball at the origin.
pub(crate) fn ball(pose: Pose, radius: f64) -> Frame {
    let camera = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5)).unwrap();
    let camera_position = pose.translation();
    let depth = (0..160 * 120).map(|i| {
        let ideal = camera.deproject(DVec2::new((i % 160) as f64, (i / 160) as f64)).unwrap();
        let ray = pose.rotation() * ideal.extend(1.0);
        let (a, b) = (ray.length_squared(), ray.dot(camera_position));
        let root = b * b - a * (camera_position.length_squared() - radius * radius);
        if root > 0.0 { ((-b - root.sqrt()) / a) as f32 } else { f32::INFINITY }
    });
    let image = DepthImage::from_metres(160, 120, depth.collect()).unwrap();
    Frame::new(image, camera, pose, 2.0).unwrap()
}

/// A frame of these depths, metres, by column and row, from a camera at the origin.
pub(crate) fn of_depth(width: u32, height: u32, depth: impl Fn(u32, u32) -> f32) -> Frame {
    let focal = DVec2::splat(50.0);
    let camera = Intrinsics::pinhole(width, height, focal, DVec2::new(10.0, 8.0)).unwrap();
    let depth = (0..width * height).map(|i| depth(i % width, i / width)).collect();
    Frame::new(DepthImage::from_metres(width, height, depth).unwrap(), camera, Pose::IDENTITY, 2.0).unwrap()
}
