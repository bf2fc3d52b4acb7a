use super::preorder::{DEPTH, KEY_OFFSET};
use super::tree::{Node, Octree, TreeKind};
use crate::Error;
use crate::geometry::VoxelKey;
use glam::IVec3;

impl Octree {
    /// An `OcTree` with one leaf per voxel, given in any order as key and log-odds; `voxel_size` is in
    /// metres. Inner nodes get the highest log-odds of their children (OctoMap's `updateInnerOccupancy`).
    /// Without voxels the tree has no nodes.
    ///
    /// Fails if the voxel size is not positive and finite, a key lies outside -32768..32768, log-odds are not
    /// finite, or a key comes twice.
    pub fn from_voxels(
        voxel_size: f64,
        voxels: impl IntoIterator<Item = (VoxelKey, f32)>,
    ) -> Result<Self, Error> {
        if !(voxel_size > 0.0 && voxel_size.is_finite()) {
            return Err(Error::invalid("voxel_size", voxel_size, "a positive number of metres"));
        }
        let mut voxels = voxels
            .into_iter()
            .map(|(key, log_odds)| Ok((preorder_code(key)?, check_log_odds(key, log_odds)?)))
            .collect::<Result<Vec<_>, Error>>()?;
        voxels.sort_unstable_by_key(|&(code, _)| code);
        if let Some(pair) = voxels.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(Error::invalid("voxel key", key_of(pair[0].0), "each voxel only once"));
        }
        Ok(from_sorted(voxel_size, &voxels))
    }
}

/// Orders voxels by preorder: the octants on the way down from the root, three bits each.
fn preorder_code(key: VoxelKey) -> Result<u64, Error> {
    let range = -KEY_OFFSET..KEY_OFFSET;
    if !key.to_array().iter().all(|k| range.contains(k)) {
        return Err(Error::invalid("voxel key", key, "-32768 to 32767 on each axis, the reach of an octree"));
    }
    let octomap_key = (key + KEY_OFFSET).as_u64vec3();
    let octants = (0..DEPTH).map(|level| {
        let bits = octomap_key >> u64::from(level) & 1;
        (bits.x | bits.y << 1 | bits.z << 2) << (3 * level)
    });
    Ok(octants.sum())
}

/// The inverse of [`preorder_code`].
fn key_of(code: u64) -> VoxelKey {
    let bit = |axis: u8, level: u8| ((code >> (3 * level + axis) & 1) as i32) << level;
    IVec3::from_array([0, 1, 2].map(|axis| (0..DEPTH).map(|level| bit(axis, level)).sum())) - KEY_OFFSET
}

fn check_log_odds(key: VoxelKey, log_odds: f32) -> Result<f32, Error> {
    let problem = || Error::invalid("log-odds", format!("{log_odds} at voxel {key}"), "a finite number");
    log_odds.is_finite().then_some(log_odds).ok_or_else(problem)
}

fn from_sorted(voxel_size: f64, voxels: &[(u64, f32)]) -> Octree {
    let mut tree = Octree::new(TreeKind::OcTree, voxel_size);
    // Indices of the nodes from the root to the parent of the voxel.
    let mut path = Vec::with_capacity(DEPTH.into());
    let mut previous = None;
    for &(code, log_odds) in voxels {
        path.truncate(previous.map_or(0, |previous| n_shared_ancestors(previous, code)));
        path.iter().for_each(|&idx| tree.raise(idx, log_odds));
        while path.len() <= DEPTH.into() {
            if let Some(&parent) = path.last() {
                tree.add_child(parent, octant(code, path.len()));
            }
            path.push(tree.push(Node::leaf(log_odds)));
        }
        previous = Some(code);
    }
    tree
}

/// Number of nodes that lie on the way to both voxels, the root included.
fn n_shared_ancestors(a: u64, b: u64) -> usize {
    let n_equal_bits = (a ^ b).leading_zeros() as usize - (64 - 3 * usize::from(DEPTH));
    n_equal_bits / 3 + 1
}

/// The octant that the voxel's ancestor at `depth` has in its parent.
fn octant(code: u64, depth: usize) -> usize {
    (code >> (3 * (usize::from(DEPTH) - depth)) & 7) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reaches_every_corner_of_the_key_range() {
        for corner in 0..8 {
            let key = IVec3::from_array([0, 1, 2].map(|axis| [-32768, 32767][corner >> axis & 1]));
            assert_eq!(key_of(preorder_code(key).unwrap()), key);
            let tree = Octree::from_voxels(0.1, [(key, 1.0)]).unwrap();
            assert_eq!((tree.n_nodes(), tree.leaves().next().unwrap().min), (17, key));
        }
    }

    #[test]
    fn inner_nodes_get_the_highest_log_odds_below_them() {
        let voxels = [([0, 0, 0], -1.0), ([1, 0, 0], 0.5), ([0, 0, 2], 2.0), ([-1, 0, 0], -3.0)];
        let tree = Octree::from_voxels(0.1, voxels.map(|(key, l)| (key.into(), l))).unwrap();
        let inner_at = |depth, min| {
            let mut nodes = tree.nodes();
            nodes.find(|(place, _)| place.depth == depth && place.min == min).unwrap().1.log_odds
        };
        assert_eq!(inner_at(15, IVec3::ZERO), 0.5);
        assert_eq!(inner_at(14, IVec3::ZERO), 2.0);
        assert_eq!(inner_at(15, IVec3::new(-2, 0, 0)), -3.0);
        assert_eq!(inner_at(0, IVec3::splat(-32768)), 2.0);
    }

    #[test]
    fn refuses_voxels_that_no_tree_can_hold() {
        let check = |voxels: &[(IVec3, f32)], expected: &str| {
            let problem = Octree::from_voxels(0.1, voxels.iter().copied()).unwrap_err().to_string();
            assert_eq!(problem, expected);
        };
        let key = IVec3::new(1, -2, 3);
        check(
            &[(key, 0.5), (IVec3::ZERO, 0.0), (key, 0.5)],
            "voxel key is [1, -2, 3], expected each voxel only once",
        );
        for outside in [IVec3::new(0, 32768, 0), IVec3::new(-32769, 0, 0), IVec3::MAX, IVec3::MIN] {
            let range = "expected -32768 to 32767 on each axis, the reach of an octree";
            check(&[(outside, 0.0)], &format!("voxel key is {outside}, {range}"));
        }
        check(&[(key, f32::NAN)], "log-odds is NaN at voxel [1, -2, 3], expected a finite number");
        for voxel_size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Octree::from_voxels(voxel_size, []).is_err());
        }
    }
}
