//! The walls behind the object.

use super::chunk::Chunk;
use super::samples::ImageSamples;
use crate::SimError;
use glam::DVec3;
use nextview::Error;
use nextview::geometry::{Aabb, Pose};

/// Fails if part of the mesh lies outside.
pub(super) fn check_holds_mesh(room: &Aabb, mesh: &Aabb) -> Result<(), SimError> {
    if room.size().is_finite() && room.contains(mesh.min) && room.contains(mesh.max) {
        return Ok(());
    }
    let value = format!("{} to {} m", room.min, room.max);
    Err(SimError::parameter("room", value, "a box that contains the whole mesh"))
}

/// Fails if the camera is outside.
pub(super) fn check_holds_camera(room: &Aabb, world_from_camera: &Pose) -> Result<(), Error> {
    let position = world_from_camera.translation();
    if position.cmpgt(room.min).all() && position.cmplt(room.max).all() {
        return Ok(());
    }
    Err(Error::InvalidParameter {
        name: "camera position",
        value: format!("{position} m"),
        expected: "a point inside the room",
    })
}

/// Puts the walls at the samples where no surface is, as 1 / depth. The camera must be inside.
pub(super) fn add_walls(
    room: &Aabb,
    samples: &ImageSamples,
    world_from_camera: &Pose,
    nearest: &mut [Chunk],
) {
    let origin = world_from_camera.translation();
    let rotation = world_from_camera.rotation_matrix();
    let (to_low, to_high) = (1.0 / (room.min - origin), 1.0 / (room.max - origin));
    let (x, y) = (samples.x().as_flattened(), samples.y().as_flattened());
    for ((&x, &y), nearest) in x.iter().zip(y).zip(nearest.as_flattened_mut()) {
        if *nearest == 0.0 {
            // Ray points are `origin + depth * direction`.
            *nearest = inverse_depth_of_wall(rotation * DVec3::new(x, y, 1.0), to_low, to_high);
        }
    }
}

/// 1 / depth at which a ray leaves the room: along each axis, its speed over the distance to the wall ahead.
/// The nearest wall has the largest.
fn inverse_depth_of_wall(direction: DVec3, inverse_to_low: DVec3, inverse_to_high: DVec3) -> f64 {
    (direction * inverse_to_low).max(direction * inverse_to_high).max_element()
}
