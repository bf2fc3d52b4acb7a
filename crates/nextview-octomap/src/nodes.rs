use crate::preorder::{NodeCube, Preorder};
use crate::tree::{Leaf, Octree, StoredNode, TreeKind};

impl Octree {
    /// Returns the leaves in preorder: octant by octant, x varying fastest, then y, then z.
    pub fn leaves(&self) -> impl Iterator<Item = Leaf> {
        self.nodes().filter(|(_, node)| node.child_mask == 0).map(|(place, node)| Leaf {
            min: place.min + self.origin(),
            depth: place.depth,
            log_odds: node.log_odds,
            color: (self.kind() == TreeKind::ColorOcTree).then_some(node.color),
        })
    }

    pub(crate) fn nodes(&self) -> Nodes<'_> {
        Nodes::new(self)
    }
}

/// The nodes of a tree in preorder, with their places.
pub(crate) struct Nodes<'a> {
    tree: &'a Octree,
    idx: usize,
    preorder: Preorder,
}

impl<'a> Nodes<'a> {
    pub fn new(tree: &'a Octree) -> Self {
        Self { tree, idx: 0, preorder: Preorder::new() }
    }

    /// Returns the index of the next node.
    pub fn next_idx(&self) -> usize {
        self.idx
    }
}

impl Iterator for Nodes<'_> {
    type Item = (NodeCube, StoredNode);

    fn next(&mut self) -> Option<(NodeCube, StoredNode)> {
        if self.idx == self.tree.n_nodes() {
            return None;
        }
        let place = self.preorder.next_place()?;
        let node = self.tree.node(self.idx);
        self.preorder.descend(place, node.child_mask);
        self.idx += 1;
        Some((place, node))
    }
}
