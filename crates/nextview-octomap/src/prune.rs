use crate::preorder::DEPTH;
use crate::tree::{Octree, StoredNode, TreeKind};
use nextview::Error;
use std::borrow::Cow;

impl Octree {
    /// Returns the tree with eight equal leaves merged into one, like OctoMap's `prune()`.
    ///
    /// Equal means equal log-odds; colours do not count. The merged leaf is white (no colour set) if the
    /// first of the eight is, otherwise it has the average of those that are not white, rounded down. As in
    /// OctoMap, pruning starts with the voxels, stops at the first level without a merge, and never merges
    /// the root's children, which gives the same bytes.
    pub fn pruned(&self) -> Self {
        let mut tree = Cow::Borrowed(self);
        for depth in (1..DEPTH).rev() {
            let pruned = tree.pruned_at(depth);
            let is_done = pruned.n_nodes() == tree.n_nodes();
            tree = Cow::Owned(pruned);
            if is_done {
                break;
            }
        }
        tree.into_owned()
    }

    /// Returns the tree with every leaf split into single voxels of its occupancy and colour: the inverse of
    /// [`pruned`](Self::pruned).
    ///
    /// Fails if there would be more than `max_leaves` leaves: a single leaf may stand for 2^48.
    pub fn expanded(&self, max_leaves: usize) -> Result<Self, Error> {
        let n_leaves: u64 = self.leaves().map(|leaf| u64::from(leaf.edge()).pow(3)).sum();
        if n_leaves > max_leaves as u64 {
            return Err(Error::TooLarge {
                what: format!("an octree expanded to {n_leaves} voxels, with at most {max_leaves} allowed,"),
                needed_mb: self.megabytes(n_leaves),
                limit_mb: self.megabytes(max_leaves as u64),
            });
        }
        let mut tree = Self::new(self.kind(), self.voxel_size()).with_origin(self.origin());
        for (place, node) in self.nodes() {
            match node.child_mask {
                0 => tree.push_cube(node, place.depth),
                _ => drop(tree.push(node)),
            }
        }
        Ok(tree)
    }

    fn pruned_at(&self, depth: u8) -> Self {
        let mut tree = Self::new(self.kind(), self.voxel_size()).with_origin(self.origin());
        let mut nodes = self.nodes();
        while let Some((place, node)) = nodes.next() {
            let first_child = nodes.next_idx();
            if place.depth == depth && self.are_eight_equal_leaves(node.child_mask, first_child) {
                tree.push(self.merged_leaf(first_child));
                nodes.nth(7);
            } else {
                tree.push(node);
            }
        }
        tree
    }

    /// Sibling leaves are consecutive in preorder.
    fn are_eight_equal_leaves(&self, parents_mask: u8, first: usize) -> bool {
        let log_odds = |idx| self.node(idx).log_odds;
        parents_mask == u8::MAX
            && (first..first + 8).all(|i| self.node(i).child_mask == 0 && log_odds(i) == log_odds(first))
    }

    fn merged_leaf(&self, first: usize) -> StoredNode {
        let leaf = self.node(first);
        if leaf.color == StoredNode::WHITE {
            return leaf;
        }
        let colors = || (first..first + 8).map(|i| self.node(i).color).filter(|&c| c != StoredNode::WHITE);
        let sum = |channel: usize| colors().map(|c| u32::from(c[channel])).sum::<u32>();
        let n_colors = colors().count() as u32;
        StoredNode { color: [0, 1, 2].map(|channel| (sum(channel) / n_colors) as u8), ..leaf }
    }

    /// Appends the full tree below a leaf at `depth`.
    fn push_cube(&mut self, leaf: StoredNode, depth: u8) {
        if depth == DEPTH {
            self.push(leaf);
            return;
        }
        self.push(StoredNode { child_mask: u8::MAX, ..leaf });
        for _ in 0..8 {
            self.push_cube(leaf, depth + 1);
        }
    }

    /// Returns the memory of a full tree with this many leaves, rounded up; a seventh is added for inner
    /// nodes.
    fn megabytes(&self, n_leaves: u64) -> u64 {
        let bytes_per_node = match self.kind() {
            TreeKind::OcTree => 5,
            TreeKind::ColorOcTree => 8,
        };
        (n_leaves.saturating_mul(bytes_per_node) / 7).saturating_mul(8).div_ceil(1_000_000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::IVec3;

    /// A chain from the root down to a node at `depth` with eight leaves of these colours.
    fn eight_leaves(depth: u8, colors: [[u8; 3]; 8]) -> Octree {
        let mut tree = Octree::new(TreeKind::ColorOcTree, 0.1);
        for _ in 0..depth {
            tree.push(StoredNode { child_mask: 1, ..StoredNode::leaf(0.85) });
        }
        tree.push(StoredNode { child_mask: u8::MAX, ..StoredNode::leaf(0.85) });
        for color in colors {
            tree.push(StoredNode { color, ..StoredNode::leaf(0.85) });
        }
        tree
    }

    #[test]
    fn averages_the_colors_that_are_set_unless_the_first_is_not() {
        let merged = |colors| eight_leaves(15, colors).pruned().leaves().next().unwrap().color.unwrap();
        let (red, white) = ([255, 0, 0], StoredNode::WHITE);
        assert_eq!(merged([[7, 9, 11]; 8]), [7, 9, 11]);
        assert_eq!(merged([[1, 2, 3], [2, 4, 8], white, white, white, white, white, white]), [1, 3, 5]);
        assert_eq!(merged([white, red, red, red, red, red, red, red]), white);
    }

    #[test]
    fn stops_at_the_first_level_without_anything_to_merge() {
        assert_eq!(eight_leaves(15, [[0; 3]; 8]).pruned().n_nodes(), 16);
        assert_eq!(eight_leaves(14, [[0; 3]; 8]).pruned().n_nodes(), 15 + 8);
    }

    #[test]
    fn never_merges_the_roots_children() {
        let mut tree = eight_leaves(0, [[0; 3]; 8]);
        assert_eq!(tree.pruned_at(0).n_nodes(), 1, "they are equal");
        tree = tree.pruned();
        assert_eq!(tree.n_nodes(), 9);
    }

    #[test]
    fn merges_over_many_levels_and_splits_again() {
        let block = (0..512).map(|i| (IVec3::new(i % 8, i / 8 % 8, i / 64), 0.85));
        let tree = Octree::from_voxels(0.1, block).unwrap();
        let pruned = tree.pruned();
        assert_eq!(pruned.n_leaves(), 1);
        assert_eq!(pruned.leaves().next().unwrap().edge(), 8);
        assert_eq!(pruned.expanded(512).unwrap(), tree);
    }

    #[test]
    fn refuses_to_expand_beyond_the_limit() {
        let mut tree = Octree::new(TreeKind::OcTree, 0.1);
        tree.push(StoredNode::leaf(0.0));
        let problem = tree.expanded(1_000_000).unwrap_err().to_string();
        assert_eq!(
            problem,
            "an octree expanded to 281474976710656 voxels, with at most 1000000 allowed, \
             would need 1608428439 MB, more than the limit of 6 MB"
        );
    }
}
