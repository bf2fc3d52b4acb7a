use super::{Depth, DepthImage, Intrinsics};
use crate::{Error, geometry::Pose};
use glam::{DVec2, DVec3};

/// One look of a depth camera: the image, the optics that made it, and where the camera stood.
#[derive(Clone, Debug)]
pub struct Frame {
    image: DepthImage,
    intrinsics: Intrinsics,
    world_from_camera: Pose,
    range: f64,
}

impl Frame {
    /// A frame; the image must have the size that the intrinsics state, and `range`, the depth in metres up to
    /// which a pixel without return is known to be free, must be positive.
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

    /// The depth image.
    pub fn image(&self) -> &DepthImage {
        &self.image
    }

    /// The optics.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Where the camera stood.
    pub fn world_from_camera(&self) -> Pose {
        self.world_from_camera
    }

    /// The depth in metres up to which a pixel without return is known to be free.
    pub fn range(&self) -> f64 {
        self.range
    }

    /// The end of every ray that says something, in world coordinates: row by row, with
    /// `true` for a measured surface and `false` for the end of the range where nothing came back.
    pub fn ray_ends(&self) -> impl Iterator<Item = (DVec3, bool)> + '_ {
        (0..self.image.height()).flat_map(|v| self.row_ray_ends(v))
    }

    /// [`ray_ends`](Self::ray_ends) of one image row.
    pub fn row_ray_ends(&self, v: u32) -> impl Iterator<Item = (DVec3, bool)> + '_ {
        let rotation = self.world_from_camera.rotation_matrix();
        let translation = self.world_from_camera.translation();
        (0..self.image.width()).filter_map(move |u| {
            let (depth, is_surface) = match self.image.get(u, v) {
                Depth::Missing => return None,
                Depth::Beyond => (self.range, false),
                Depth::Surface(depth) => (depth as f64, true),
            };
            let ideal = self.intrinsics.deproject(DVec2::new(u as f64, v as f64))?;
            Some((rotation * (ideal.extend(1.0) * depth) + translation, is_surface))
        })
    }

    /// The measured surface points in world coordinates, metres, row by row.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.ray_ends().filter_map(|(end, is_surface)| is_surface.then_some(end))
    }
}
