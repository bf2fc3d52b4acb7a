//! The orientation of the surface at every pixel of a frame, from its neighbours.

use crate::sensor::{Depth, Frame};
use glam::{DVec2, Vec3};
use rayon::prelude::*;

/// Surfaces seen at a flatter angle than this cosine are ignored: half a pixel across the ray is then more
/// than two along it, and flying pixels between object and background look like such surfaces.
const MIN_COSINE: f32 = 0.2;

/// The plane that touches the surface at a pixel, in the camera frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentPlane {
    /// Unit normal, towards the camera.
    pub normal: Vec3,
    /// `normal` times any point of the plane, metres; negative.
    pub offset: f32,
    /// Depth of the pixel, metres.
    pub depth: f32,
    /// Cosine between the normal and the direction to the camera.
    pub cosine: f32,
}

/// The tangent planes of a frame, computed on demand: few are needed, and a plane takes twice the memory of a
/// point.
pub struct TangentPlanes {
    width: usize,
    /// The measured points in the camera frame, row by row; zero where nothing was measured.
    points: Vec<Vec3>,
}

impl TangentPlanes {
    /// Prepares the planes of a frame.
    pub fn new(frame: &Frame) -> Self {
        let (image, intrinsics) = (frame.image(), frame.intrinsics());
        let point = |i: u32| {
            let (u, v) = (i % image.width(), i / image.width());
            let Depth::Surface(depth) = image.get(u, v) else { return None };
            let ideal = intrinsics.deproject(DVec2::new(u as f64, v as f64))?;
            Some((ideal.extend(1.0) * depth as f64).as_vec3())
        };
        let n_pixels = intrinsics.n_pixels() as u32;
        let points = (0..n_pixels).into_par_iter().map(|i| point(i).unwrap_or(Vec3::ZERO)).collect();
        Self { width: image.width() as usize, points }
    }

    /// Returns the plane at a pixel, counted row by row; `None` if the pixel or its neighbours on an axis
    /// were not measured, or if the surface is seen at less than 12 degrees.
    pub fn at(&self, pixel: usize) -> Option<TangentPlane> {
        let point = self.point(pixel)?;
        let (u, stride) = (pixel % self.width, self.width);
        let left = if u > 0 { self.point(pixel - 1) } else { None };
        let right = if u + 1 < stride { self.point(pixel + 1) } else { None };
        let above = if pixel >= stride { self.point(pixel - stride) } else { None };
        let along_u = tangent(left, point, right)?;
        let along_v = tangent(above, point, self.point(pixel + stride))?;
        TangentPlane::new(point, along_v.cross(along_u))
    }

    /// Returns the measured point at a pixel, counted row by row, in metres in the camera frame; `None` if
    /// nothing was measured there.
    pub fn point(&self, pixel: usize) -> Option<Vec3> {
        self.points.get(pixel).copied().filter(|point| point.z > 0.0)
    }
}

/// Returns the direction of the surface from the neighbours before and after: the difference with the smaller
/// step in depth, which stays on the surface at a silhouette.
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

    use crate::sensor::synthetic::of_depth as frame;

    #[test]
    fn unmeasured_pixels_and_lone_ones_have_no_plane() {
        let hole = frame(5, 5, |u, v| if (u, v) == (2, 2) { f32::NAN } else { 0.5 });
        let n_planes = |planes: TangentPlanes| (0..25).filter(|&pixel| planes.at(pixel).is_some()).count();
        assert_eq!(n_planes(TangentPlanes::new(&hole)), 24);
        let lone = frame(5, 5, |u, v| if (u, v) == (2, 2) { 0.5 } else { f32::NAN });
        assert_eq!(n_planes(TangentPlanes::new(&lone)), 0);
        let flying = frame(5, 5, |u, v| if (u, v) == (2, 2) { 0.5 } else { 1.0 });
        assert!(TangentPlanes::new(&flying).at(12).is_none());
    }
}
