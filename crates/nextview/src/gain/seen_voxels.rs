//! Known surface that a view shows again, for the gains of second looks.

use crate::geometry::{Lattice, Pose};
use crate::map::{Occupancy, Snapshot};
use crate::sensor::{DepthRange, Intrinsics};
use crate::visibility::{FreeSpace, RayCaster, RayEnd, Sight};

/// Distance between neighbouring rays at the far side of the box, in voxels.
const RAY_SPACING: f64 = 2.0;

/// The ray caster for second looks of a camera with these optics and depths.
pub(super) fn caster<'a>(
    snapshot: &'a Snapshot,
    intrinsics: &Intrinsics,
    depth_range: DepthRange,
) -> RayCaster<'a> {
    let sight = Sight::endless(FreeSpace::Clear);
    let caster = RayCaster::new(snapshot, intrinsics, RAY_SPACING, sight);
    caster.expect("the spacing is positive").within(depth_range)
}

/// Returns the occupied voxels of the snapshot that a view shows, in increasing order.
pub(super) fn occupied_voxels(caster: &RayCaster<'_>, world_from_camera: &Pose) -> Vec<u32> {
    let mut voxels = Vec::new();
    caster.cast(world_from_camera, |ray| {
        if let RayEnd::Occupied(crossing) = &ray.end {
            voxels.push(crossing.voxel);
        }
    });
    voxels.sort_unstable();
    voxels.dedup();
    voxels
}

/// Whether gains of second looks are meaningful: surface measured in cells of this lattice says nothing about
/// coarser voxels.
pub(crate) fn is_in_measured_voxels(snapshot: &Snapshot, measured: &Lattice) -> bool {
    snapshot.lattice() == *measured && snapshot.count(Occupancy::Occupied) > 0
}
