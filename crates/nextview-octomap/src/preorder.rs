use glam::IVec3;
use nextview::geometry::VoxelKey;

/// Depth of single voxels: OctoMap's keys have 16 bits.
pub(crate) const DEPTH: u8 = 16;

/// OctoMap's key of our voxel 0, and the extent of its keys to both sides.
pub(crate) const KEY_OFFSET: i32 = 1 << (DEPTH - 1);

/// The place of a node in space.
#[derive(Clone, Copy)]
pub(crate) struct NodeCube {
    pub min: VoxelKey,
    pub depth: u8,
}

impl NodeCube {
    fn child(self, octant: u8) -> Self {
        let depth = self.depth + 1;
        let bits = IVec3::new(octant as i32 & 1, octant as i32 >> 1 & 1, octant as i32 >> 2);
        Self { min: self.min + (bits << (DEPTH - depth) as i32), depth }
    }
}

/// The places of the nodes of a tree, in preorder.
pub(crate) struct Preorder {
    /// The next place on top. At most seven siblings wait on each level.
    pending: Vec<NodeCube>,
}

impl Preorder {
    pub fn new() -> Self {
        Self { pending: vec![NodeCube { min: IVec3::splat(-KEY_OFFSET), depth: 0 }] }
    }

    /// Returns the place of the next node; `None` if the tree is complete.
    pub fn next_place(&mut self) -> Option<NodeCube> {
        self.pending.pop()
    }

    /// Adds the children of the node at `place`, which must not be at the greatest depth.
    pub fn descend(&mut self, place: NodeCube, child_mask: u8) {
        self.pending.extend((0..8).rev().filter(|i| child_mask >> i & 1 == 1).map(|i| place.child(i)));
    }
}
