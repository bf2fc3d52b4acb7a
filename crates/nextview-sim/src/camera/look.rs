use super::SimulatedCamera;
use glam::{DMat3, DVec3};
use nextview::geometry::{Aabb, Pose};

/// The part of the object that a camera truly measures from a pose.
#[derive(Clone)]
pub struct Look<'a> {
    camera: &'a SimulatedCamera,
    /// The pose: world from camera.
    rotation: DMat3,
    position: DVec3,
    /// Metres, row by row; not finite where no point of the object is measured.
    depth: Vec<f32>,
}

impl<'a> Look<'a> {
    pub(super) fn new(camera: &'a SimulatedCamera, world_from_camera: &Pose, depth: Vec<f32>) -> Self {
        let rotation = world_from_camera.rotation_matrix();
        Self { camera, rotation, position: world_from_camera.translation(), depth }
    }

    /// Returns the measured points inside the box, in world coordinates, row by row. They are those of
    /// [`Frame::points_in`](nextview::sensor::Frame::points_in) of [`Capture::truth`](super::Capture::truth),
    /// in less time because the camera knows every pixel's ray.
    pub fn points_in(&self, bounds: Aabb) -> impl Iterator<Item = DVec3> + '_ {
        let pixels = self.depth.iter().zip(self.camera.samples().ideal_points());
        let surface = pixels.filter(|(depth, _)| depth.is_finite());
        let points =
            surface.map(|(depth, ideal)| self.rotation * (ideal.extend(1.0) * *depth as f64) + self.position);
        points.filter(move |point| bounds.contains(*point))
    }

    /// Returns whether a point (world coordinates, metres) is visible: the nearest pixel measures the object
    /// within `distance` metres in depth.
    pub fn shows(&self, point: DVec3, distance: f64) -> bool {
        let point = self.rotation.transpose() * (point - self.position);
        let intrinsics = self.camera.intrinsics();
        let Some(pixel) = intrinsics.project(point).map(|pixel| pixel.round()) else { return false };
        let (width, height) = (intrinsics.width() as usize, intrinsics.height() as usize);
        if !(pixel.min_element() >= 0.0 && pixel.x < width as f64 && pixel.y < height as f64) {
            return false;
        }
        let depth = self.depth[pixel.y as usize * width + pixel.x as usize] as f64;
        (depth - point.z).abs() * point.length() <= distance * point.z
    }
}
