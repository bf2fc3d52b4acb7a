//! The voxels that a triangle overlaps.

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3, Vec3Swizzles};
use nextview::geometry::{Lattice, VoxelBlock, VoxelKey};
use robust::{Coord, Coord3D, orient2d, orient3d};

/// A triangle in units of voxels. It may be degenerate: a line or a point.
///
/// Its overlap with a box of voxels is decided by the separating axis test for triangle and box
/// (Akenine-Möller 2001) with two changes. A voxel owns its lower faces but not its upper ones, as in
/// [`Lattice::key`]. All signs are exact: neither the order of the corners nor rounding decides whether a
/// triangle through a voxel's corner counts.
///
/// Strict and non-strict comparisons mix for this reason: the half-open box `low..high` meets the closed
/// triangle if and only if some closed box `low..=high - e` does, e > 0. On an axis n, the largest value of
/// that box is `n . c` with c at `high` where n is positive and at `low` elsewhere, minus e times the sum of
/// n's positive parts. The triangle must not lie beyond: strictly, if n has a positive part, since it must
/// leave room for e.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VoxelTriangle {
    corners: [DVec3; 3],
    /// The signs of the normal's components: the orientation of the triangle seen along x, y and z.
    normal: DVec3,
}

impl VoxelTriangle {
    /// Creates the triangle with these corners, metres.
    pub fn new(corners: [DVec3; 3], lattice: &Lattice) -> Self {
        let corners = corners.map(|corner| lattice.to_voxels(corner));
        let turn = |axis| rotation(corners.map(|corner| along(corner, axis)));
        Self { corners, normal: DVec3::new(turn(0), turn(1), turn(2)) }
    }

    /// Calls `visit` once with each voxel of the block that holds a point of the triangle.
    pub fn for_each_voxel(&self, block: &VoxelBlock, visit: impl FnMut(VoxelKey)) {
        self.for_each_voxel_within(0.0, block, visit);
    }

    /// Calls `visit` with each voxel that, widened by a margin on each side, in voxels, holds a point of the
    /// triangle.
    pub fn for_each_voxel_within(&self, margin: f64, block: &VoxelBlock, mut visit: impl FnMut(VoxelKey)) {
        let low = (self.low() - margin).floor().as_ivec3();
        let high = (self.high() + margin).floor().as_ivec3();
        if low == high && block.index(low).is_some() {
            return visit(low); // the whole triangle is in one voxel
        }
        let (low, high) = (low.max(block.min()), high.min(block.max()));
        if low.cmple(high).all() {
            self.divide(low, high, margin, &mut visit);
        }
    }

    /// Visits the voxels from `low` to `high`, both included, by halves: if a half does not meet the
    /// triangle, none of its voxels does.
    fn divide(&self, low: VoxelKey, high: VoxelKey, margin: f64, visit: &mut impl FnMut(VoxelKey)) {
        if !self.meets(low.as_dvec3() - margin, (high + 1).as_dvec3() + margin) {
            return;
        }
        if low == high {
            return visit(low);
        }
        let axis = (high - low).max_position();
        let middle = low[axis] + (high[axis] - low[axis]) / 2;
        let (mut end_of_first, mut start_of_second) = (high, low);
        (end_of_first[axis], start_of_second[axis]) = (middle, middle + 1);
        self.divide(low, end_of_first, margin, visit);
        self.divide(start_of_second, high, margin, visit);
    }

    /// Whether the triangle has a point in the box: at or above `low` and below `high` on every axis.
    fn meets(&self, low: DVec3, high: DVec3) -> bool {
        self.low().cmplt(high).all()
            && self.high().cmpge(low).all()
            && self.plane_meets(low, high)
            && (0..3).all(|axis| self.outline_meets(axis, along(low, axis), along(high, axis)))
    }

    /// Whether the box is not entirely on one side of the triangle's plane.
    fn plane_meets(&self, low: DVec3, high: DVec3) -> bool {
        let (up, down) = (self.normal.cmpgt(DVec3::ZERO), self.normal.cmplt(DVec3::ZERO));
        let top = self.height(DVec3::select(up, high, low));
        let bottom = self.height(DVec3::select(down, high, low));
        reaches(top, up.any()) && reaches(-bottom, down.any())
    }

    /// A number with the sign of a point's height above the plane.
    fn height(&self, point: DVec3) -> f64 {
        let [a, b, c, d] = [self.corners[0], self.corners[1], self.corners[2], point].map(|p| Coord3D {
            x: p.x,
            y: p.y,
            z: p.z,
        });
        -orient3d(a, b, c, d)
    }

    /// Whether the box, seen along an axis, is not beyond an edge of the triangle. A triangle that is a line
    /// there has both of its sides outside.
    fn outline_meets(&self, axis: usize, low: DVec2, high: DVec2) -> bool {
        let [a, b, c] = self.corners.map(|corner| along(corner, axis));
        let turn = self.normal[axis];
        [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
            (turn < 0.0 || is_left_of(low, high, from, to)) && (turn > 0.0 || is_left_of(low, high, to, from))
        })
    }

    fn low(&self) -> DVec3 {
        self.corners[0].min(self.corners[1]).min(self.corners[2])
    }

    fn high(&self) -> DVec3 {
        self.corners[0].max(self.corners[1]).max(self.corners[2])
    }
}

/// Whether part of the rectangle is to the left of the line between two points, or on it.
fn is_left_of(low: DVec2, high: DVec2, from: DVec2, to: DVec2) -> bool {
    let grows = DVec2::new(from.y, to.x).cmpgt(DVec2::new(to.y, from.x));
    reaches(rotation([from, to, DVec2::select(grows, high, low)]), grows.any())
}

/// Whether a box reaches the triangle along an axis. `value` is the largest value of the box on the axis,
/// relative to the triangle; the box does not attain that of an upper face.
fn reaches(value: f64, is_of_upper_face: bool) -> bool {
    value > 0.0 || value == 0.0 && !is_of_upper_face
}

/// The point seen along an axis; the other two axes form a right-handed system.
fn along(point: DVec3, axis: usize) -> DVec2 {
    match axis {
        0 => point.yz(),
        1 => point.zx(),
        _ => point.xy(),
    }
}

/// Positive if three points turn left, negative if they turn right, and zero on a line.
fn rotation(points: [DVec2; 3]) -> f64 {
    let [a, b, c] = points.map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}
