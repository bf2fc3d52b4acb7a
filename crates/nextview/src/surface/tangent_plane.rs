//! The direction of the surface at every pixel of a frame, from its neighbours.

use crate::sensor::{Depth, Frame};
use glam::{DVec2, Vec3};
use rayon::prelude::*;

/// Surfaces seen at a flatter angle than this cosine are ignored: half a pixel beside the ray is then more
/// than two along it, and flying pixels between object and background look like such surfaces.
const MIN_COSINE: f32 = 0.2;

/// The plane that touches the surface at a pixel, in the camera frame.
#[derive(Clone, Copy)]
pub(super) struct TangentPlane {
    /// Unit, towards the camera.
    pub normal: Vec3,
    /// `normal` times any point of the plane.
    pub offset: f32,
    /// Depth of the pixel.
    pub depth: f32,
    /// Cosine between the normal and the direction to the camera.
    pub cosine: f32,
}

/// The tangent plane of every pixel that has one, row by row.
pub(super) fn tangent_planes(frame: &Frame) -> Vec<Option<TangentPlane>> {
    let (width, height) = (frame.image().width() as usize, frame.image().height() as usize);
    let points = points_in_camera(frame);
    let at = |u: usize, v: usize| if u < width && v < height { points[v * width + u] } else { None };
    (0..width * height)
        .into_par_iter()
        .map(|i| {
            let (u, v, point) = (i % width, i / width, points[i]?);
            let along_u = tangent(at(u.wrapping_sub(1), v), point, at(u + 1, v))?;
            let along_v = tangent(at(u, v.wrapping_sub(1)), point, at(u, v + 1))?;
            TangentPlane::new(point, along_v.cross(along_u))
        })
        .collect()
}

/// The measured points row by row.
fn points_in_camera(frame: &Frame) -> Vec<Option<Vec3>> {
    let (image, intrinsics) = (frame.image(), frame.intrinsics());
    (0..intrinsics.n_pixels() as u32)
        .into_par_iter()
        .map(|i| {
            let (u, v) = (i % image.width(), i / image.width());
            let Depth::Surface(depth) = image.get(u, v) else { return None };
            let ideal = intrinsics.deproject(DVec2::new(u as f64, v as f64))?;
            Some((ideal.extend(1.0) * depth as f64).as_vec3())
        })
        .collect()
}

/// The direction of the surface from its neighbours before and after: of the two differences the one with the
/// smaller step in depth, which at a silhouette is the one that stays on the surface.
fn tangent(before: Option<Vec3>, point: Vec3, after: Option<Vec3>) -> Option<Vec3> {
    match (before.map(|b| point - b), after.map(|a| a - point)) {
        (Some(back), Some(ahead)) => Some(if back.z.abs() < ahead.z.abs() { back } else { ahead }),
        (back, ahead) => back.or(ahead),
    }
}

impl TangentPlane {
    fn new(point: Vec3, normal: Vec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let offset = normal.dot(point);
        let cosine = -offset / point.length();
        (cosine >= MIN_COSINE).then_some(Self { normal, offset, depth: point.z, cosine })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::sensor::made_up::of_depth as frame;

    #[test]
    fn unmeasured_pixels_and_lone_ones_have_no_plane() {
        let hole = frame(5, 5, |u, v| if (u, v) == (2, 2) { f32::NAN } else { 0.5 });
        assert_eq!(tangent_planes(&hole).iter().filter(|plane| plane.is_none()).count(), 1);
        let lone = frame(5, 5, |u, v| if (u, v) == (2, 2) { 0.5 } else { f32::NAN });
        assert!(tangent_planes(&lone).iter().all(Option::is_none));
        let flying = frame(5, 5, |u, v| if (u, v) == (2, 2) { 0.5 } else { 1.0 });
        assert!(tangent_planes(&flying)[12].is_none());
    }
}
