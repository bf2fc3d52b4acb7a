use super::chunk::Chunk;
use super::draw_list::DrawList;
use super::samples::ImageSamples;
use super::{projection, raster, room};
use crate::SimError;
use crate::mesh::TriangleMesh;
use crate::noise::Noise;
use nextview::Error;
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::Intrinsics;
use std::sync::Arc;

/// The background of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// Nothing: those pixels report free space up to the camera's range.
    None,
    /// The inner walls of a closed room around the object and all camera positions.
    Room(Aabb),
}

/// A depth camera that looks at a mesh in world coordinates.
///
/// A pixel shows the depth at which the ray through its centre first meets the mesh, from either side, or the
/// background. Surfaces nearer than 1 mm (in depth) are not seen; surfaces beyond the range have no return.
/// Pixels for which the lens model has no answer are missing.
///
/// ```
/// use glam::{DQuat, DVec2, DVec3};
/// use nextview::geometry::Pose;
/// use nextview::sensor::{Depth, Intrinsics};
/// use nextview_sim::camera::{Background, SimulatedCamera};
/// use nextview_sim::mesh::TriangleMesh;
///
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
/// let intrinsics = Intrinsics::pinhole(64, 48, DVec2::splat(60.0), DVec2::new(31.5, 23.5)).unwrap();
/// let camera = SimulatedCamera::new(mesh.into(), intrinsics, Background::None, 3.0).unwrap();
///
/// let looking_down = DQuat::from_rotation_x(std::f64::consts::PI);
/// let pose = Pose::new(looking_down, DVec3::new(0.3, 0.3, 2.0)).unwrap();
/// let frame = camera.capture(&pose).unwrap();
/// assert_eq!(frame.image().get(32, 24), Depth::Surface(2.0));
/// assert_eq!(frame.image().get(0, 0), Depth::Beyond);
/// ```
#[derive(Clone)]
pub struct SimulatedCamera {
    mesh: Arc<TriangleMesh>,
    intrinsics: Intrinsics,
    background: Background,
    range: f64,
    noise: Noise,
    list: Arc<DrawList>,
    samples: Arc<ImageSamples>,
}

impl SimulatedCamera {
    /// Creates a camera with these optics and a range of `range_m` metres of depth.
    ///
    /// Fails if the range is not a positive number, if the lens model has no answer for any pixel, or if the
    /// mesh extends beyond the room.
    pub fn new(
        mesh: Arc<TriangleMesh>,
        intrinsics: Intrinsics,
        background: Background,
        range_m: f64,
    ) -> Result<Self, SimError> {
        if !(range_m > projection::MIN_DEPTH && range_m.is_finite()) {
            return Err(SimError::parameter("range_m", range_m, "a finite number of metres above 0.001"));
        }
        if let Background::Room(room) = background {
            room::check_holds_mesh(&room, &mesh.bounds())?;
        }
        let samples = ImageSamples::new(&intrinsics).ok_or_else(|| {
            let value = format!("{:?}", intrinsics.distortion());
            SimError::parameter("distortion", value, "a lens model that has an answer inside the image")
        })?;
        let (list, samples) = (DrawList::new(&mesh).into(), samples.into());
        Ok(Self { mesh, intrinsics, background, range: range_m, noise: Noise::default(), list, samples })
    }

    /// Sets the camera's errors; fails if one is out of range.
    pub fn with_noise(self, noise: Noise) -> Result<Self, SimError> {
        noise.check()?;
        Ok(Self { noise, ..self })
    }

    /// Returns the mesh the camera looks at.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.mesh
    }

    /// Returns the camera's errors.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// Returns the optics.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Largest depth that is measured, metres.
    pub(super) fn range(&self) -> f64 {
        self.range
    }

    pub(super) fn background(&self) -> Background {
        self.background
    }

    pub(super) fn samples(&self) -> &ImageSamples {
        &self.samples
    }

    /// Returns the exact image from a pose, without noise, as plain numbers, row by row: depth in metres,
    /// infinite where there is no return, NaN where the lens model has no answer.
    pub fn render_depth(&self, world_from_camera: &Pose) -> Result<Vec<f32>, Error> {
        let mut nearest = self.nearest_surfaces(world_from_camera)?;
        self.add_background(world_from_camera, &mut nearest);
        Ok(self.depth(&nearest))
    }

    /// The exact images with and without the background.
    pub(super) fn render(&self, world_from_camera: &Pose) -> Result<Rendering, Error> {
        let mut nearest = self.nearest_surfaces(world_from_camera)?;
        let object = self.depth(&nearest);
        self.add_background(world_from_camera, &mut nearest);
        Ok(Rendering { all: self.depth(&nearest), object })
    }

    /// Adds the background where there is no surface.
    fn add_background(&self, world_from_camera: &Pose, nearest: &mut [Chunk]) {
        if let Background::Room(room) = &self.background {
            room::add_walls(room, &self.samples, world_from_camera, nearest);
        }
    }

    /// The exact image of the object alone.
    pub(super) fn render_object(&self, world_from_camera: &Pose) -> Result<Vec<f32>, Error> {
        Ok(self.depth(&self.nearest_surfaces(world_from_camera)?))
    }

    /// The object at every sample, as 1 / depth.
    fn nearest_surfaces(&self, world_from_camera: &Pose) -> Result<Vec<Chunk>, Error> {
        if let Background::Room(room) = &self.background {
            room::check_holds_camera(room, world_from_camera)?;
        }
        Ok(raster::nearest_surfaces(&self.samples, &self.list, world_from_camera))
    }

    /// Plain numbers of inverse depths.
    fn depth(&self, nearest: &[Chunk]) -> Vec<f32> {
        let farthest = 1.0 / self.range;
        let mut depth = Vec::with_capacity(self.intrinsics.n_pixels());
        for row in nearest.chunks_exact(self.samples.chunks_in_row()) {
            let width = self.intrinsics.width() as usize;
            depth.extend(row.as_flattened()[..width].iter().map(|&inverse_depth| {
                let is_seen = inverse_depth >= farthest;
                let depth = if is_seen { (1.0 / inverse_depth) as f32 } else { f32::INFINITY };
                if inverse_depth < f64::INFINITY { depth } else { f32::NAN }
            }));
        }
        depth
    }
}

/// Exact images from a pose, in the form of [`SimulatedCamera::render_depth`].
pub(super) struct Rendering {
    /// The object and the background.
    pub all: Vec<f32>,
    /// The object alone. As a room is convex and holds both the object and the camera, no wall hides any of
    /// it.
    pub object: Vec<f32>,
}
