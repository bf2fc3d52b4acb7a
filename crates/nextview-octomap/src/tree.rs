use crate::preorder::DEPTH;
use nextview::geometry::VoxelKey;

/// OctoMap's tree type, the `id` in its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeKind {
    /// Occupancy only.
    OcTree,
    /// Occupancy and a colour per node.
    ColorOcTree,
}

/// The nodes of an OctoMap octree: an immutable copy of a file.
///
/// The root covers the keys -32768 to 32767 on each axis around its [origin](Self::origin) (OctoMap's own
/// keys are 32768 higher), halved [16 times](Self::MAX_DEPTH) down to single voxels. Space without a leaf is
/// unknown. Inner nodes keep the log-odds and colours from the file.
///
/// ```
/// use glam::IVec3;
/// use nextview_octomap::Octree;
///
/// let tree = Octree::from_voxels(0.01, [(IVec3::new(3, -4, 5), 0.85)]).unwrap();
/// let mut file = Vec::new();
/// tree.write_ot(&mut file).unwrap();
///
/// let read = Octree::read(&file[..]).unwrap();
/// assert_eq!(read.voxel_size(), 0.01);
/// let leaf = read.leaves().next().unwrap();
/// assert_eq!((leaf.min, leaf.edge(), leaf.log_odds), (IVec3::new(3, -4, 5), 1, 0.85));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Octree {
    kind: TreeKind,
    voxel_size: f64,
    origin: VoxelKey,
    /// One entry per node in preorder, as in `child_masks`; all finite.
    log_odds: Vec<f32>,
    /// One entry per node of a `ColorOcTree`, empty otherwise.
    colors: Vec<[u8; 3]>,
    /// Bit `i` set: the node has a child in octant `i`, whose bits 0, 1, 2 choose the upper half in x, y, z.
    child_masks: Vec<u8>,
}

impl Octree {
    /// Number of halvings between the root and a single voxel.
    pub const MAX_DEPTH: u8 = DEPTH;

    /// Returns the tree type.
    pub fn kind(&self) -> TreeKind {
        self.kind
    }

    /// Returns the edge of a voxel, a leaf at the greatest depth, in metres; positive and finite.
    pub fn voxel_size(&self) -> f64 {
        self.voxel_size
    }

    /// Returns the voxel in the middle of the root. It is 0 except for distant maps; their files give it in a
    /// comment `# offset_m X Y Z`, in metres. OctoMap's own programs show such maps displaced by that much.
    pub fn origin(&self) -> VoxelKey {
        self.origin
    }

    /// Sets the origin.
    pub(crate) fn with_origin(self, origin: VoxelKey) -> Self {
        Self { origin, ..self }
    }

    /// Returns the number of nodes, inner nodes and leaves.
    pub fn n_nodes(&self) -> usize {
        self.child_masks.len()
    }

    /// Counts the leaves.
    pub fn n_leaves(&self) -> usize {
        self.child_masks.iter().filter(|&&mask| mask == 0).count()
    }

    pub(crate) fn new(kind: TreeKind, voxel_size: f64) -> Self {
        let (log_odds, colors, child_masks) = Default::default();
        Self { kind, voxel_size, origin: VoxelKey::ZERO, log_odds, colors, child_masks }
    }

    pub(crate) fn node(&self, idx: usize) -> StoredNode {
        StoredNode {
            log_odds: self.log_odds[idx],
            color: self.colors.get(idx).copied().unwrap_or(StoredNode::WHITE),
            child_mask: self.child_masks[idx],
        }
    }

    /// Appends a node in preorder and returns its index.
    pub(crate) fn push(&mut self, node: StoredNode) -> usize {
        self.log_odds.push(node.log_odds);
        if self.kind == TreeKind::ColorOcTree {
            self.colors.push(node.color);
        }
        self.child_masks.push(node.child_mask);
        self.child_masks.len() - 1
    }

    pub(crate) fn add_child(&mut self, idx: usize, octant: usize) {
        self.child_masks[idx] |= 1 << octant;
    }

    /// OctoMap's rule for inner nodes: the highest log-odds of the children, the first of equals.
    pub(crate) fn raise(&mut self, idx: usize, log_odds: f32) {
        if log_odds > self.log_odds[idx] {
            self.log_odds[idx] = log_odds;
        }
    }

    #[cfg(test)]
    pub(crate) fn map_log_odds(mut self, change: impl Fn(f32) -> f32) -> Self {
        self.log_odds.iter_mut().for_each(|l| *l = change(*l));
        self
    }
}

/// A node without children: a cube of space with one occupancy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// The voxel of the cube with the lowest coordinates, in the lattice of the world.
    pub min: VoxelKey,
    /// Number of halvings from the root to the cube, 0 to 16; 16 is a single voxel.
    pub depth: u8,
    /// Log-odds of being occupied, as in the file.
    pub log_odds: f32,
    /// Red, green, blue, in a `ColorOcTree` only; white is OctoMap's "no colour set".
    pub color: Option<[u8; 3]>,
}

impl Leaf {
    /// Returns the edge of the cube in voxels, 1 to 65536.
    pub fn edge(&self) -> u32 {
        1 << (DEPTH - self.depth)
    }

    /// Returns the voxel of the cube with the highest coordinates.
    pub fn max(&self) -> VoxelKey {
        self.min + self.edge() as i32 - 1
    }

    /// Returns the lowest and the highest voxel that the cube shares with the box of voxels from `low` to
    /// `high`, both included; `None` if they share none.
    pub fn part_between(&self, low: VoxelKey, high: VoxelKey) -> Option<(VoxelKey, VoxelKey)> {
        let (min, max) = (self.min.max(low), self.max().min(high));
        min.cmple(max).all().then_some((min, max))
    }
}

/// One node as stored in files.
#[derive(Clone, Copy)]
pub(crate) struct StoredNode {
    pub log_odds: f32,
    pub color: [u8; 3],
    pub child_mask: u8,
}

impl StoredNode {
    /// OctoMap's colour of a node without a colour.
    pub const WHITE: [u8; 3] = [255; 3];

    pub fn leaf(log_odds: f32) -> Self {
        Self { log_odds, color: Self::WHITE, child_mask: 0 }
    }
}
