use super::brick::{BRICK_EDGE, brick_key};
use crate::geometry::{VoxelBlock, VoxelKey};
use glam::{DVec3, IVec3};

/// A box of voxels, given by its lowest and its highest voxel, both included. Unlike a [`VoxelBlock`] it may
/// span all keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KeyBox {
    pub min: VoxelKey,
    pub max: VoxelKey,
}

impl KeyBox {
    pub fn of(block: VoxelBlock) -> Self {
        Self { min: block.min(), max: block.max() }
    }

    pub fn contains(&self, key: VoxelKey) -> bool {
        key.cmpge(self.min).all() && key.cmple(self.max).all()
    }

    /// Whether the box contains the voxel with these integers as its key.
    #[inline(always)]
    pub fn contains_floor(&self, floor: DVec3) -> bool {
        floor.cmpge(self.min.as_dvec3()).all() && floor.cmple(self.max.as_dvec3()).all()
    }

    /// Returns the box extended by a voxel.
    pub fn with(self, key: VoxelKey) -> Self {
        Self { min: self.min.min(key), max: self.max.max(key) }
    }

    /// Returns the number of bricks between the lowest and the highest along each axis.
    fn brick_steps(&self) -> IVec3 {
        brick_key(self.max) - brick_key(self.min)
    }

    /// Splits the box along its longest axis into halves of whole bricks; `None` if no edge has more than
    /// `max_bricks` bricks.
    pub fn halves(&self, max_bricks: i32) -> Option<[Self; 2]> {
        let steps = self.brick_steps();
        let axis = steps.max_position();
        (steps[axis] >= max_bricks).then(|| {
            let middle = (brick_key(self.min)[axis] + steps[axis] / 2 + 1) * BRICK_EDGE;
            let (mut low, mut high) = (*self, *self);
            (low.max[axis], high.min[axis]) = (middle - 1, middle);
            [low, high]
        })
    }

    /// Returns the block of bricks that the box touches; the box must be small enough for one.
    pub fn bricks(&self) -> VoxelBlock {
        VoxelBlock::new(brick_key(self.min), (self.brick_steps() + 1).as_uvec3())
            .expect("a box holds at least one voxel")
    }

    /// Whether a segment, in units of voxels, comes near the box: false only if it crosses no voxel of it,
    /// and almost always true only if it does. (Separating axes: Ericson 2004, section 5.3.3, without
    /// divisions.)
    #[inline(always)]
    pub fn is_near(&self, from: DVec3, to: DVec3) -> bool {
        let (min, max) = (self.min.as_dvec3(), self.max.as_dvec3() + 1.0);
        // A thousandth of a voxel is far more than the rounding of a walk.
        let extent = 0.5 * (max - min) + 1e-3;
        let half = 0.5 * (to - from);
        let middle = 0.5 * (from + to) - 0.5 * (min + max);
        let reach = half.abs();
        let apart = middle.abs().cmpgt(extent + reach);
        let across = middle.cross(half).abs();
        let limit = DVec3::new(
            extent.y * reach.z + extent.z * reach.y,
            extent.z * reach.x + extent.x * reach.z,
            extent.x * reach.y + extent.y * reach.x,
        );
        !(apart | across.cmpgt(limit)).any()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::SegmentWalk;
    use proptest::prelude::*;

    fn position() -> impl Strategy<Value = DVec3> {
        let any = (-9.0..9.0, -9.0..9.0, -9.0..9.0).prop_map(|(x, y, z)| DVec3::new(x, y, z));
        let tied = (-36..36, -36..36, -36..36).prop_map(|(x, y, z)| IVec3::new(x, y, z).as_dvec3() * 0.25);
        prop_oneof![any, tied]
    }

    proptest! {
        #[test]
        fn every_segment_that_crosses_a_box_is_near_it(
            from in position(), to in position(), min in prop::array::uniform3(-6..3), dims in prop::array::uniform3(0..9),
        ) {
            let min = IVec3::from_array(min);
            let keys = KeyBox { min, max: min + IVec3::from_array(dims) };
            let crosses = SegmentWalk::within(from, to, keys.min, keys.max).is_some();
            prop_assert!(keys.is_near(from, to) || !crosses);
        }
    }

    #[test]
    fn halves_are_whole_bricks_and_leave_nothing_out() {
        let whole = KeyBox { min: IVec3::new(-125, i32::MIN, 3), max: IVec3::new(124, i32::MAX, 4) };
        let [low, high] = whole.halves(16).unwrap();
        assert_eq!((low.max.y, high.min.y), (-1, 0), "the longest axis");
        let flat = KeyBox { min: IVec3::new(-125, 0, 3), max: IVec3::new(124, 0, 4) };
        let [low, high] = flat.halves(16).unwrap();
        assert_eq!((low.max.x, high.min.x), (-1, 0));
        assert_eq!((low.halves(16), low.bricks().dims().x), (None, 16));
    }

    #[test]
    fn segments_far_off_are_not_near() {
        let keys = KeyBox { min: IVec3::ZERO, max: IVec3::splat(9) };
        assert!(!keys.is_near(DVec3::new(-5.0, 5.0, 5.0), DVec3::new(5.0, 16.0, 5.0)));
        assert!(keys.is_near(DVec3::new(-5.0, 5.0, 5.0), DVec3::new(5.0, 14.0, 5.0)));
    }
}
