//! An object in front of a camera: positions and sizes.

use crate::SimError;
use crate::camera::{Background, SimulatedCamera};
use crate::mesh::TriangleMesh;
use crate::noise::Noise;
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::object::planning_box;
use nextview::sensor::Intrinsics;
use std::sync::Arc;

/// Range of the simulated camera, metres, as the D435i's data sheet states it.
pub const CAMERA_RANGE: f64 = 10.0;

/// Half-side of the room, metres; independent of the object, unless the object would fill it.
const ROOM: f64 = 2.0;

/// An object in the middle of a room, with the box that planners know.
#[derive(Clone)]
pub struct Scene {
    camera: SimulatedCamera,
    bounds: Aabb,
    center: DVec3,
    room: Aabb,
}

impl Scene {
    /// Places the mesh (metres, world coordinates) in a room with sides of 4 m, or larger if the object's
    /// longest side is above 0.67 m: the walls stand behind all usual view candidates.
    ///
    /// Fails if the object is too large for the camera: it must be within [`CAMERA_RANGE`] from four times
    /// its half-side, the distance of the paper's farthest views.
    pub fn new(mesh: TriangleMesh, intrinsics: Intrinsics) -> Result<Self, SimError> {
        let object = mesh.bounds();
        let size = 0.5 * object.longest_side();
        if 6.0 * size > CAMERA_RANGE {
            let longest = object.longest_side();
            return Err(SimError::TooLargeForCamera { longest_side: longest, range: CAMERA_RANGE });
        }
        let room = Aabb::cube(object.center(), ROOM.max(6.0 * size));
        Ok(Self {
            camera: camera(Arc::new(mesh), intrinsics, room)?,
            bounds: object,
            center: object.center(),
            room,
        })
    }

    /// Puts the object on a table: raises the room's floor to the object's lowest point.
    pub fn with_table(self) -> Result<Self, SimError> {
        let room = Aabb { min: self.room.min.with_z(self.bounds.min.z), ..self.room };
        let camera = camera(self.camera.mesh().clone(), *self.camera.intrinsics(), room)?;
        Ok(Self { camera: camera.with_noise(*self.camera.noise())?, room, ..self })
    }

    /// Sets the point at which view candidates look, instead of the middle of the object's box.
    pub fn with_center(self, center: DVec3) -> Self {
        Self { center, ..self }
    }

    /// Sets the camera's errors; fails if one is out of range.
    pub fn with_noise(self, noise: Noise) -> Result<Self, SimError> {
        Ok(Self { camera: self.camera.with_noise(noise)?, ..self })
    }

    /// Returns the camera that looks at the object.
    pub fn camera(&self) -> &SimulatedCamera {
        &self.camera
    }

    /// Returns the point at which view candidates look: by default the middle of the object's box.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Returns the object's box.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Returns the room around the object; the camera must stand inside.
    pub fn room(&self) -> Aabb {
        self.room
    }

    /// Returns half the longest side of the object's box, metres: the paper's object size.
    pub fn size(&self) -> f64 {
        0.5 * self.bounds.longest_side()
    }

    /// Returns the cube around the object that planners know: its [planning box](planning_box) for voxels of
    /// this size, metres.
    pub fn planning_box(&self, voxel_size: f64) -> Aabb {
        planning_box(&self.bounds, voxel_size)
    }
}

fn camera(mesh: Arc<TriangleMesh>, intrinsics: Intrinsics, room: Aabb) -> Result<SimulatedCamera, SimError> {
    SimulatedCamera::new(mesh, intrinsics, Background::Room(room), 2.0 * CAMERA_RANGE)
}
