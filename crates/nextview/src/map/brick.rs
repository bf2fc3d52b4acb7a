use glam::IVec3;
use rustc_hash::FxHashMap;

/// Voxels along the edge of a brick. A ray then changes brick every five to eight steps, so that hashing
/// costs less than stepping, and a brick of log-odds is 2 kB.
const EDGE_BITS: i32 = 3;
pub(crate) const BRICK_EDGE: i32 = 1 << EDGE_BITS;

/// Number of voxels in a brick.
pub(crate) const CELLS: usize = 1 << (3 * EDGE_BITS);

/// Returns the brick that contains a voxel.
pub(crate) fn brick_key(key: IVec3) -> IVec3 {
    key >> EDGE_BITS
}

/// Returns the index of a voxel in its brick, x varying fastest.
pub(crate) fn cell(key: IVec3) -> usize {
    let local = key & (BRICK_EDGE - 1);
    (local.x | local.y << EDGE_BITS | local.z << (2 * EDGE_BITS)) as usize
}

/// Returns the voxel at an index of a brick: the inverse of [`brick_key`] and [`cell`].
pub(crate) fn voxel_key(brick: IVec3, cell: usize) -> IVec3 {
    let cell = cell as i32;
    (brick << EDGE_BITS)
        + IVec3::new(cell & (BRICK_EDGE - 1), cell >> EDGE_BITS & (BRICK_EDGE - 1), cell >> (2 * EDGE_BITS))
}

/// A sparse, unbounded grid of bricks.
#[derive(Clone, Debug)]
pub(crate) struct BrickGrid<B> {
    slots: FxHashMap<IVec3, u32>,
    /// Bricks in the order of creation, which must not influence any result.
    bricks: Vec<(IVec3, B)>,
}

impl<B> Default for BrickGrid<B> {
    fn default() -> Self {
        Self { slots: FxHashMap::default(), bricks: Vec::new() }
    }
}

impl<B: Default> BrickGrid<B> {
    pub(crate) fn get(&self, brick: IVec3) -> Option<&B> {
        self.slots.get(&brick).map(|&slot| &self.bricks[slot as usize].1)
    }

    /// Returns the slot of a brick; creates an empty brick if there is none.
    pub(crate) fn slot(&mut self, brick: IVec3) -> usize {
        let next = self.bricks.len() as u32;
        let slot = *self.slots.entry(brick).or_insert(next);
        if slot == next {
            self.bricks.push((brick, B::default()));
        }
        slot as usize
    }

    pub(crate) fn at_mut(&mut self, slot: usize) -> &mut B {
        &mut self.bricks[slot].1
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (IVec3, &B)> {
        self.bricks.iter().map(|(key, brick)| (*key, brick))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_inverses_on_both_sides_of_zero() {
        for key in [IVec3::ZERO, IVec3::new(-1, 7, 8), IVec3::new(-8, -9, 1000), IVec3::splat(-123_456)] {
            assert_eq!(voxel_key(brick_key(key), cell(key)), key);
            assert!(cell(key) < CELLS);
        }
    }
}
