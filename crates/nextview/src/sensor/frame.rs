use super::{Depth, DepthImage, Intrinsics};
use crate::Error;
use crate::geometry::{Aabb, Pose};
use glam::{DMat3, DVec2, DVec3};

/// One measurement of a depth camera: its image, optics and pose.
#[derive(Clone, Debug)]
pub struct Frame {
    image: DepthImage,
    intrinsics: Intrinsics,
    world_from_camera: Pose,
    range: f64,
}

impl Frame {
    /// Returns a frame. The image must have the size of the intrinsics, and `range`, the depth in metres up
    /// to which a pixel without return is known to be free, must be positive.
    pub fn new(
        image: DepthImage,
        intrinsics: Intrinsics,
        world_from_camera: Pose,
        range: f64,
    ) -> Result<Self, Error> {
        let (width, height) = (intrinsics.width(), intrinsics.height());
        if (image.width(), image.height()) != (width, height) {
            let actual = image.width() as usize * image.height() as usize;
            return Err(Error::ImageSize { actual, width, height });
        }
        if !(range > 0.0 && range.is_finite()) {
            return Err(Error::invalid("range", range, "a positive number of metres"));
        }
        Ok(Self { image, intrinsics, world_from_camera, range })
    }

    /// Sets the camera pose.
    pub fn with_pose(self, world_from_camera: Pose) -> Self {
        Self { world_from_camera, ..self }
    }

    pub(crate) fn move_to(&mut self, world_from_camera: Pose) {
        self.world_from_camera = world_from_camera;
    }

    /// Returns the depth image.
    pub fn image(&self) -> &DepthImage {
        &self.image
    }

    /// Returns the optics.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Returns the camera pose.
    pub fn world_from_camera(&self) -> Pose {
        self.world_from_camera
    }

    /// Returns the depth in metres up to which a pixel without return is known to be free.
    pub fn range(&self) -> f64 {
        self.range
    }

    /// Returns the pixel that shows a point of the camera frame, or its occluder; `None` outside the image.
    pub(crate) fn pixel_at(&self, point_in_camera: DVec3) -> Option<Depth> {
        let pixel = self.intrinsics.project(point_in_camera)?;
        let at = self.intrinsics.contains(pixel).then(|| pixel.round().as_uvec2())?;
        Some(self.image.get(at.x, at.y))
    }

    /// Returns the end of every measured ray of image row `v`, in world coordinates, from left to right: with
    /// `true` for a surface and `false` for the end of the range of a ray without return.
    pub fn row_ray_ends(&self, v: u32) -> impl Iterator<Item = (DVec3, bool)> + '_ {
        let rotation = self.world_from_camera.rotation_matrix();
        let row = self.intrinsics.deproject_row(v);
        (0..).zip(row).filter_map(move |(u, ideal)| match self.image.get(u, v) {
            Depth::Missing => None,
            Depth::Beyond => Some((self.place(&rotation, ideal?, self.range), false)),
            Depth::Surface(depth) => Some((self.place(&rotation, ideal?, depth as f64), true)),
        })
    }

    /// Returns all measured surface points, in world coordinates, row by row.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        let ends = (0..self.image.height()).flat_map(|v| self.row_ray_ends(v));
        ends.filter(|(_, hit)| *hit).map(|(point, _)| point)
    }

    /// Returns the measured surface points inside the box, which must be finite, in world coordinates, row by
    /// row.
    pub fn points_in(&self, bounds: Aabb) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.image.height()).flat_map(move |v| self.row_points_in(v, bounds))
    }

    /// As [`points_in`](Self::points_in), for image row `v`, from left to right.
    pub fn row_points_in(&self, v: u32, bounds: Aabb) -> impl Iterator<Item = DVec3> + '_ {
        self.row_pixels_in(v, bounds).map(|(_, point)| point)
    }

    /// As [`row_points_in`](Self::row_points_in), with the column of each point's pixel.
    pub(crate) fn row_pixels_in(&self, v: u32, bounds: Aabb) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        // Most pixels show the background; their depth alone rules them out, before the lens is undone.
        let camera_from_world = self.world_from_camera.inverse();
        let corner_depths = bounds.corners().map(|corner| camera_from_world.transform_point(corner).z as f32);
        let nearest = corner_depths.into_iter().fold(f32::INFINITY, f32::min) * (1.0 - f32::EPSILON);
        let farthest = corner_depths.into_iter().fold(0.0, f32::max) * (1.0 + f32::EPSILON);
        let rotation = self.world_from_camera.rotation_matrix();
        (0..self.image.width()).filter_map(move |u| match self.image.get(u, v) {
            Depth::Surface(depth) if (nearest..=farthest).contains(&depth) => {
                let point = self.at(&rotation, u, v, depth as f64);
                point.filter(|point| bounds.contains(*point)).map(|point| (u, point))
            }
            _ => None,
        })
    }

    /// Returns the point of pixel `(u, v)` at this depth; `None` if the lens model has no answer.
    fn at(&self, rotation: &DMat3, u: u32, v: u32, depth: f64) -> Option<DVec3> {
        Some(self.place(rotation, self.intrinsics.deproject(DVec2::new(u as f64, v as f64))?, depth))
    }

    /// Returns the point at this depth on the ray through `ideal`.
    #[inline(always)]
    fn place(&self, rotation: &DMat3, ideal: DVec2, depth: f64) -> DVec3 {
        *rotation * (ideal.extend(1.0) * depth) + self.world_from_camera.translation()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::look_at;

    #[test]
    fn points_in_a_box_are_all_points_that_lie_in_it() {
        let camera = Intrinsics::d435i();
        let depth = (0..camera.n_pixels()).map(|i| 0.2 + (i % 97) as f32 * 0.005).collect();
        let pose = look_at(DVec3::new(0.3, 0.2, 0.1), DVec3::ZERO).unwrap();
        let frame = Frame::new(DepthImage::from_metres(640, 480, depth).unwrap(), camera, pose, 1.0).unwrap();
        for bounds in [Aabb::cube(DVec3::ZERO, 0.1), Aabb::cube(DVec3::new(0.3, 0.2, 0.1), 0.15)] {
            let ends = (0..480).flat_map(|v| frame.row_ray_ends(v)).map(|(end, _)| end);
            let expected: Vec<DVec3> = ends.filter(|end| bounds.contains(*end)).collect();
            assert_eq!(frame.points_in(bounds).collect::<Vec<_>>(), expected);
            assert!(!expected.is_empty());
        }
    }
}
