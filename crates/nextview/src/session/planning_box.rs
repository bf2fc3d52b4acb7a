use crate::geometry::Aabb;

/// Room around the object, as a share of its size and in voxels on each side.
const MARGIN: f64 = 1.1;
const MARGIN_IN_VOXELS: f64 = 2.0;

/// The cube to plan in around an object whose box (metres) is known: a tenth larger than its longest side and
/// two voxels (metres) wider on each side, so that free space around it is seen.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Aabb;
/// use nextview::session::planning_box;
///
/// let bounds = planning_box(&Aabb { min: DVec3::ZERO, max: DVec3::new(0.1, 0.2, 0.1) }, 0.01);
/// assert!(bounds.center().distance(DVec3::new(0.05, 0.1, 0.05)) < 1e-12);
/// assert!((bounds.longest_side() - 0.26).abs() < 1e-12);
/// ```
pub fn planning_box(object: &Aabb, voxel_size: f64) -> Aabb {
    let half_side = 0.5 * object.longest_side();
    Aabb::cube(object.center(), MARGIN * half_side + MARGIN_IN_VOXELS * voxel_size)
}

/// The same rounded to whole voxels: centre and half-side, so that the box of an object that grows by less
/// stays as it is, and so do its maps.
pub(super) fn growing_box(object: &Aabb, voxel_size: f64) -> Aabb {
    let half = (MARGIN * 0.5 * object.longest_side() / voxel_size + MARGIN_IN_VOXELS).ceil();
    Aabb::cube((object.center() / voxel_size).round() * voxel_size, half * voxel_size)
}
