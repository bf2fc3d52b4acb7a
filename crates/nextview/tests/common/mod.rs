//! The voxels of a ray, without the library's walk.

use glam::{DVec3, IVec3};
use nextview::geometry::VoxelBlock;

/// The voxels of a block that a ray crosses, in order: every column of voxels is cut with the ray, and every
/// voxel of it. Origin and direction are in voxels. Touching an edge or a corner is no crossing.
pub fn crossed(block: VoxelBlock, origin: DVec3, direction: DVec3) -> Vec<IVec3> {
    // From where to where a ray is between two faces of a voxel.
    let between = |axis: usize, index: i32| {
        let faces = [index, index + 1].map(|face| f64::from(face) - origin[axis]);
        if direction[axis] == 0.0 {
            return if faces[0] <= 0.0 && 0.0 < faces[1] { (0.0, f64::INFINITY) } else { (0.0, 0.0) };
        }
        let [a, b] = faces.map(|face| face / direction[axis]);
        (a.min(b), a.max(b))
    };
    let both = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.min(b.1));
    let is_crossed = |part: (f64, f64)| part.1 - part.0 > 1e-9;
    let indices = |axis: usize| block.min()[axis]..block.min()[axis] + block.dims()[axis] as i32;
    let mut parts = Vec::new();
    for x in indices(0) {
        for y in indices(1) {
            let column = both(both((0.0, f64::INFINITY), between(0, x)), between(1, y));
            if is_crossed(column) {
                let part = |z| (both(column, between(2, z)), IVec3::new(x, y, z));
                parts.extend(indices(2).map(part).filter(|(part, _)| is_crossed(*part)));
            }
        }
    }
    parts.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
    parts.into_iter().map(|(_, key)| key).collect()
}
