use crate::geometry::{Aabb, Lattice, Moments, Pose};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;
use std::ops::Add;

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Metres.
    pub position: DVec3,
    /// Of unit length, pointing out of the surface.
    pub normal: DVec3,
}

impl SurfacePoint {
    /// Returns the point in another frame.
    pub fn moved(&self, pose: &Pose) -> Self {
        Self { position: pose.transform_point(self.position), normal: pose.rotation() * self.normal }
    }
}

/// Cells processed between two checks for cancellation.
const CHUNK: usize = 1 << 12;

/// Minimum number of pixels around a point for a normal.
const LEAST_PIXELS: f64 = 8.0;

/// Surfaces seen at a flatter angle than this cosine are skipped, as in the distance field: half a pixel
/// across the ray is more than two along it.
const LEAST_COSINE: f64 = 0.2;

/// Returns the measured points in the box (world coordinates, finite) with their normals, in the camera
/// frame: the mean of the pixels in each cell of `spacing` metres (a valid voxel size), in the order in which
/// the cells were first met.
///
/// The normal is from the plane through the pixels of the cell and the 26 around it (principal components,
/// Hoppe et al. 1992), since the noise of neighbouring pixels is often as large as their distance.
pub(super) fn surface_points(
    frame: &Frame,
    bounds: Aabb,
    spacing: f64,
    cancel: &Cancel,
) -> Result<Vec<SurfacePoint>, Cancelled> {
    let camera_from_world = frame.world_from_camera().inverse();
    let lattice = Lattice::new(spacing).expect("the configuration was checked");
    let mut cells = PointCells::default();
    for v in 0..frame.image().height() {
        cancel.check()?;
        for point in frame.row_points_in(v, bounds) {
            let point = camera_from_world.transform_point(point);
            cells.add(lattice.key(point), point);
        }
    }
    let mut points = Vec::new();
    for part in cells.moments.chunks(CHUNK) {
        cancel.check()?;
        points.extend(part.iter().filter_map(|(key, moments)| cells.surface_point(*key, moments)));
    }
    Ok(points)
}

/// Points pooled in cells.
#[derive(Default)]
struct PointCells {
    slots: FxHashMap<IVec3, usize>,
    moments: Vec<(IVec3, Moments)>,
}

impl PointCells {
    fn add(&mut self, key: IVec3, point: DVec3) {
        let slot = *self.slots.entry(key).or_insert(self.moments.len());
        if slot == self.moments.len() {
            self.moments.push((key, Moments::NONE));
        }
        self.moments[slot].1 = self.moments[slot].1 + Moments::of(point);
    }

    fn surface_point(&self, key: IVec3, moments: &Moments) -> Option<SurfacePoint> {
        let at =
            |offset: IVec3| self.slots.get(&key.saturating_add(offset)).map(|slot| self.moments[*slot].1);
        let around = neighborhood().filter_map(at).fold(Moments::NONE, Moments::add);
        let position = moments.sum / moments.n;
        let normal = around.normal().filter(|_| around.n >= LEAST_PIXELS)?;
        let cosine = -normal.dot(position) / position.length();
        (cosine.abs() >= LEAST_COSINE).then(|| SurfacePoint { position, normal: normal * cosine.signum() })
    }
}

fn neighborhood() -> impl Iterator<Item = IVec3> {
    (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::synthetic::ball;
    use crate::view::look_at;

    #[test]
    fn normals_of_a_ball_point_outwards() {
        let frame = ball(look_at(DVec3::new(0.3, -0.2, 0.3), DVec3::ZERO).unwrap(), 0.1);
        let never = &Cancel::default();
        let points = surface_points(&frame, Aabb::cube(DVec3::ZERO, 0.2), 0.01, never).unwrap();
        assert!(points.len() > 100, "{}", points.len());
        for point in points.iter().map(|point| point.moved(&frame.world_from_camera())) {
            assert!((point.position.length() - 0.1).abs() < 0.001, "{point:?}");
            assert!(point.normal.dot(point.position.normalize()) > 0.97, "{point:?}");
        }
    }

    #[test]
    fn what_is_outside_the_box_is_left_out() {
        let frame = ball(look_at(DVec3::new(0.3, -0.2, 0.3), DVec3::ZERO).unwrap(), 0.1);
        let upper = Aabb { min: DVec3::new(-0.2, -0.2, 0.0), max: DVec3::splat(0.2) };
        let never = &Cancel::default();
        let points = surface_points(&frame, upper, 0.01, never).unwrap();
        let lowest = points.iter().map(|point| point.moved(&frame.world_from_camera()).position.z);
        assert!(!points.is_empty() && lowest.fold(f64::INFINITY, f64::min) > -1e-9);
        assert!(surface_points(&frame, Aabb::cube(DVec3::ONE, 0.1), 0.01, never).unwrap().is_empty());
    }
}
