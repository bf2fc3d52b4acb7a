use crate::preorder::{DEPTH, KEY_OFFSET};
use crate::tree::{Octree, StoredNode, TreeKind};
use glam::IVec3;
use nextview::Error;
use nextview::geometry::{Lattice, VoxelKey, local_origin};

impl Octree {
    /// Builds an `OcTree` with one leaf per voxel, given in any order as key and log-odds; `voxel_size` is in
    /// metres. Inner nodes get the highest log-odds of their children (OctoMap's `updateInnerOccupancy`).
    /// Without voxels, the tree has no nodes.
    ///
    /// If a key lies outside -32768..32768, the [origin](Self::origin) is in the middle of all voxels.
    ///
    /// Fails if the voxel size is not positive and finite, the keys along an axis span more than 65,536,
    /// log-odds are not finite, or a key occurs twice.
    pub fn from_voxels(
        voxel_size: f64,
        voxels: impl IntoIterator<Item = (VoxelKey, f32)>,
    ) -> Result<Self, Error> {
        if !(voxel_size > 0.0 && voxel_size.is_finite()) {
            return Err(Error::invalid("voxel_size", voxel_size, "a positive number of metres"));
        }
        let voxels: Vec<(VoxelKey, f32)> = voxels.into_iter().collect();
        let origin = origin_of(&voxels)?;
        let coded = |&(key, log_odds): &(VoxelKey, f32)| {
            Ok((preorder_code(key - origin)?, check_log_odds(key, log_odds)?))
        };
        let mut voxels = voxels.iter().map(coded).collect::<Result<Vec<_>, Error>>()?;
        voxels.sort_unstable_by_key(|&(code, _)| code);
        if let Some(pair) = voxels.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(Error::invalid("voxel key", key_of(pair[0].0) + origin, "each voxel only once"));
        }
        Ok(from_sorted(voxel_size, &voxels).with_origin(origin))
    }
}

/// Returns the origin of a tree that can hold these voxels; fails if none can.
fn origin_of(voxels: &[(VoxelKey, f32)]) -> Result<VoxelKey, Error> {
    let keys = || voxels.iter().map(|(key, _)| *key);
    let (min, max) = (keys().fold(IVec3::MAX, IVec3::min), keys().fold(IVec3::MIN, IVec3::max));
    if voxels.is_empty() {
        return Ok(IVec3::ZERO);
    }
    let (low, high) = (min.as_i64vec3(), max.as_i64vec3());
    let reach = i64::from(Lattice::REACH);
    if let Some(far) = [low, high].into_iter().find(|key| key.abs().max_element() > reach) {
        return Err(Error::invalid("voxel key", far, "at most 268435456 voxels from the origin"));
    }
    if (high - low).max_element() >= 2 * i64::from(KEY_OFFSET) {
        let span = format!("{low} to {high}");
        return Err(Error::invalid(
            "voxel keys",
            span,
            "at most 65536 voxels along an axis, as in an octree",
        ));
    }
    Ok(local_origin(min, max))
}

/// Returns a code that orders voxels by preorder: the octants on the path from the root, three bits each.
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
            path.push(tree.push(StoredNode::leaf(log_odds)));
        }
        previous = Some(code);
    }
    tree
}

/// Returns the number of nodes on the paths to both voxels, including the root.
fn n_shared_ancestors(a: u64, b: u64) -> usize {
    let n_equal_bits = (a ^ b).leading_zeros() as usize - (64 - 3 * usize::from(DEPTH));
    n_equal_bits / 3 + 1
}

/// Returns the octant of the voxel's ancestor at `depth` in its parent.
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
    fn maps_far_away_have_their_origin_in_their_middle() {
        for corner in [IVec3::new(34_992, 0, 0), IVec3::new(-40_000, 7, 1 << 28), IVec3::new(-32769, 3, 2)] {
            let voxels = [(corner, 1.0), (corner + IVec3::new(65_535, 9, -3), -0.5)];
            let tree = Octree::from_voxels(0.002, voxels).unwrap();
            let mut found: Vec<_> = tree.leaves().map(|leaf| (leaf.min, leaf.log_odds)).collect();
            found.sort_by_key(|(key, _)| key.x);
            assert_eq!(found, voxels);
            assert_ne!(tree.origin(), IVec3::ZERO);
            for is_ot in [true, false] {
                let mut file = Vec::new();
                if is_ot { tree.write_ot(&mut file) } else { tree.write_bt(&mut file) }.unwrap();
                let read = Octree::read(&file[..]).unwrap();
                assert_eq!(read.origin(), tree.origin());
                assert!(read.leaves().map(|leaf| leaf.min).eq(tree.leaves().map(|leaf| leaf.min)));
            }
            assert_eq!(tree.pruned().expanded(10).unwrap().origin(), tree.origin());
        }
        let near = Octree::from_voxels(0.002, [(IVec3::splat(-32768), 1.0)]).unwrap();
        let mut file = Vec::new();
        near.write_ot(&mut file).unwrap();
        assert!(!String::from_utf8_lossy(&file).contains("offset_m"));
    }

    #[test]
    fn offsets_that_are_no_voxel_are_refused() {
        let tree = Octree::from_voxels(0.5, [(IVec3::new(40_000, 0, 0), 1.0)]).unwrap();
        let mut file = Vec::new();
        tree.write_ot(&mut file).unwrap();
        let stated = "# offset_m 20000 0 0";
        for (wrong, expected) in [
            ("# offset_m 20000 0", "expected three numbers of metres"),
            ("# offset_m 20000 0 nan", "expected three numbers of metres"),
            ("# offset_m 20000 0.1 0", "expected multiples of the voxel size"),
            ("# offset_m 1e300 0 0", "expected multiples of the voxel size"),
        ] {
            let at = file.windows(stated.len()).position(|part| part == stated.as_bytes()).unwrap();
            let changed = [&file[..at], wrong.as_bytes(), &file[at + stated.len()..]].concat();
            let problem = Octree::read(&changed[..]).unwrap_err().to_string();
            assert!(problem.contains(expected), "{problem}");
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
        for outside in [IVec3::MAX, IVec3::MIN] {
            let range = "expected at most 268435456 voxels from the origin";
            check(&[(outside, 0.0)], &format!("voxel key is {outside}, {range}"));
        }
        check(
            &[(IVec3::ZERO, 0.0), (IVec3::X * 65536, 0.0)],
            "voxel keys is [0, 0, 0] to [65536, 0, 0], expected at most 65536 voxels along an axis, as in an octree",
        );
        check(&[(key, f32::NAN)], "log-odds is NaN at voxel [1, -2, 3], expected a finite number");
        for voxel_size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Octree::from_voxels(voxel_size, []).is_err());
        }
    }
}
