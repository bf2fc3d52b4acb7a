use crate::geometry::Aabb;
use glam::DVec3;

/// Ratio of the planning box's side, without [`BOX_MARGIN_VOXELS`], to the object's longest side.
pub const BOX_MARGIN_FACTOR: f64 = 1.1;

/// Margin of the planning box on each side, voxels.
pub const BOX_MARGIN_VOXELS: f64 = 2.0;

/// Returns the cube to plan in around an object with a known box (metres): [`BOX_MARGIN_FACTOR`] times its
/// longest side, plus [`BOX_MARGIN_VOXELS`] on each side, so that free space around it is seen. The voxel
/// size is in metres.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Aabb;
/// use nextview::object::planning_box;
///
/// let bounds = planning_box(&Aabb { min: DVec3::ZERO, max: DVec3::new(0.1, 0.2, 0.1) }, 0.01);
/// assert!(bounds.center().distance(DVec3::new(0.05, 0.1, 0.05)) < 1e-12);
/// assert!((bounds.longest_side() - 0.26).abs() < 1e-12);
/// ```
pub fn planning_box(object: &Aabb, voxel_size: f64) -> Aabb {
    let half_side = 0.5 * object.longest_side();
    Aabb::cube(object.center(), BOX_MARGIN_FACTOR * half_side + BOX_MARGIN_VOXELS * voxel_size)
}

/// Estimates the object's box from that of its seen points: the same size, but moved away from the cameras. A
/// front that is wide and not deep is hardly ever the whole object; the rest is behind it. Until a camera was
/// there, the planning box must reach as far back as the front is wide.
///
/// Heights stay: the object stands on its lowest point.
pub(super) fn as_deep_as_wide(seen: &Aabb, cameras: impl Iterator<Item = DVec3>) -> Aabb {
    let (mut from_high, mut from_low) = (DVec3::ZERO, DVec3::ZERO);
    for toward in cameras.map(|camera| (camera - seen.center()).normalize_or_zero()) {
        from_high += toward.max(DVec3::ZERO);
        from_low += (-toward).max(DVec3::ZERO);
    }
    let away = (from_low - from_high) / (from_low + from_high + HALF_SURE);
    let slack = 0.5 * (DVec3::splat(seen.longest_side()) - seen.size());
    let offset = (away * slack).with_z(0.0);
    Aabb { min: seen.min + offset, max: seen.max + offset }
}

/// Number of frames from one side that move the object by half of the possible distance.
const HALF_SURE: f64 = 0.5;

/// Returns the cube around a growing object, with centre and half-side rounded to whole voxels: smaller
/// growth leaves box and maps unchanged.
pub(super) fn growing_box(object: &Aabb, voxel_size: f64) -> Aabb {
    let half = (BOX_MARGIN_FACTOR * 0.5 * object.longest_side() / voxel_size + BOX_MARGIN_VOXELS).ceil();
    Aabb::cube((object.center() / voxel_size).round() * voxel_size, half * voxel_size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_of_an_object_is_behind_its_front() {
        let front = Aabb { min: DVec3::new(0.0, -0.1, 0.0), max: DVec3::new(0.02, 0.1, 0.05) };
        let moved =
            |cameras: &[DVec3]| as_deep_as_wide(&front, cameras.iter().copied()).center() - front.center();
        let [right, left, above] = [DVec3::X, -DVec3::X, DVec3::Z].map(|at| front.center() + at);
        assert_eq!(moved(&[]), DVec3::ZERO);
        assert!((moved(&[right]) - DVec3::new(-0.06, 0.0, 0.0)).length() < 1e-12, "{}", moved(&[right]));
        assert_eq!(moved(&[right, left]), DVec3::ZERO, "both sides were seen");
        assert_eq!(moved(&[above]), DVec3::ZERO);
        assert!(moved(&[right, right]).x > -0.09);
    }
}
