use crate::geometry::Aabb;

/// Side of the box to plan in, without the voxels of [`BOX_MARGIN_VOXELS`], over the object's longest side.
pub const BOX_MARGIN_FACTOR: f64 = 1.1;

/// Voxels by which the box to plan in is wider on each side.
pub const BOX_MARGIN_VOXELS: f64 = 2.0;

/// The cube to plan in around an object whose box (metres) is known: [`BOX_MARGIN_FACTOR`] times its longest
/// side, and [`BOX_MARGIN_VOXELS`] wider on each side, so that free space around it is seen. The voxel size
/// is in metres.
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
    Aabb::cube(object.center(), BOX_MARGIN_FACTOR * half_side + BOX_MARGIN_VOXELS * voxel_size)
}

/// The same rounded to whole voxels: centre and half-side, so that the box of an object that grows by less
/// stays as it is, and so do its maps.
pub(super) fn growing_box(object: &Aabb, voxel_size: f64) -> Aabb {
    let half = (BOX_MARGIN_FACTOR * 0.5 * object.longest_side() / voxel_size + BOX_MARGIN_VOXELS).ceil();
    Aabb::cube((object.center() / voxel_size).round() * voxel_size, half * voxel_size)
}
