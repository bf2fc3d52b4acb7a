use crate::geometry::{SegmentWalk, VoxelBlock};
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU16, Ordering};

/// Marks a voxel behind no measured surface, or `limit` voxels or more behind one.
pub(super) const NOT_BEHIND: u16 = u16::MAX;

/// Returns how many voxels each voxel of the snapshot is behind a measured surface, or [`NOT_BEHIND`].
///
/// From each point that the frames measured inside the block, the ray continues behind the point, whatever
/// the map holds there. The voxel after that of the point is 1 behind it, and so on to `limit - 1`. If
/// several rays cross a voxel, the smallest number counts.
pub(super) fn voxels_behind_surface(
    snapshot: &Snapshot,
    frames: &[Frame],
    limit: u16,
    cancel: &Cancel,
) -> Result<Vec<u16>, Cancelled> {
    let behind: Vec<AtomicU16> =
        (0..snapshot.block().n_voxels()).map(|_| AtomicU16::new(NOT_BEHIND)).collect();
    // All threads write to one array: a minimum is the same in any order.
    for frame in frames {
        let rows = (0..frame.image().height()).into_par_iter().with_min_len(16);
        rows.try_for_each(|v| {
            cancel.check()?;
            mark_row(&behind, snapshot, frame, v, limit);
            Ok(())
        })?;
    }
    Ok(behind.into_iter().map(AtomicU16::into_inner).collect())
}

fn mark_row(behind: &[AtomicU16], snapshot: &Snapshot, frame: &Frame, v: u32, limit: u16) {
    let (lattice, block) = (snapshot.lattice(), snapshot.block());
    let camera = lattice.to_voxels(frame.world_from_camera().translation());
    for point in frame.row_points_in(v, lattice.bounds(&block)) {
        let point = lattice.to_voxels(point);
        if let Some(walk) = SegmentWalk::ray_within(point, point - camera, block.min(), block.max()) {
            mark_ray(behind, &block, walk, limit);
        }
    }
}

fn mark_ray(behind: &[AtomicU16], block: &VoxelBlock, mut walk: SegmentWalk, limit: u16) {
    let strides = block.strides().map(|stride| stride as isize);
    let signs = walk.step().to_array();
    let Some(mut index) = block.index(walk.key()) else { return };
    for distance in 1..limit {
        let Some(axis) = walk.advance() else { return };
        index = index.wrapping_add_signed(strides[axis] * signs[axis] as isize);
        // Most voxels already hold a smaller number, and reading is cheaper than taking the minimum.
        if behind[index].load(Ordering::Relaxed) > distance {
            behind[index].fetch_min(distance, Ordering::Relaxed);
        }
    }
}
