//! Properties of every tree and every file: round trips, and no panic on broken ones.

use crate::header::Encoding;
use crate::preorder::{DEPTH, Preorder};
use crate::tree::{Octree, StoredNode, TreeKind};
use glam::IVec3;
use proptest::prelude::*;
use std::collections::BTreeMap;

fn ot(tree: &Octree) -> Vec<u8> {
    let mut bytes = Vec::new();
    tree.write_ot(&mut bytes).unwrap();
    bytes
}

fn bt(tree: &Octree) -> Vec<u8> {
    let mut bytes = Vec::new();
    tree.write_bt(&mut bytes).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> Result<Octree, String> {
    Octree::read(bytes).map_err(|e| e.to_string())
}

fn assert_well_formed(tree: &Octree) {
    assert!(tree.voxel_size() > 0.0 && tree.voxel_size().is_finite());
    let mut preorder = Preorder::new();
    for idx in 0..tree.n_nodes() {
        let (place, node) = (preorder.next_place().unwrap(), tree.node(idx));
        assert!(node.log_odds.is_finite());
        assert!(place.depth < DEPTH || node.child_mask == 0);
        preorder.descend(place, node.child_mask);
    }
    assert!(tree.n_nodes() == 0 || preorder.next_place().is_none());
}

/// A tree with nodes from a list in preorder; leaves fill the gaps.
fn tree_of(kind: TreeKind, list: &[(u8, f32, u8)]) -> Octree {
    let mut tree = Octree::new(kind, 0.02);
    let mut preorder = Preorder::new();
    let mut list = list.iter();
    while let Some(place) = preorder.next_place() {
        let &(mask, log_odds, gray) = list.next().unwrap_or(&(0, 0.5, 9));
        let child_mask = if place.depth == DEPTH { 0 } else { mask };
        preorder.descend(place, child_mask);
        tree.push(StoredNode { log_odds, color: [gray, 255, 255], child_mask });
    }
    tree
}

fn any_tree() -> impl Strategy<Value = Octree> {
    let mask = prop_oneof![Just(255_u8), Just(0), any::<u8>()];
    let log_odds = prop_oneof![Just(0.85_f32), Just(-0.4), Just(-0.0), (-5.0..5.0).prop_map(|l| l as f32)];
    let list = prop::collection::vec((mask, log_odds, any::<u8>()), 0..60);
    let kind = prop_oneof![Just(TreeKind::OcTree), Just(TreeKind::ColorOcTree)];
    (kind, list).prop_map(|(kind, list)| tree_of(kind, &list))
}

/// Voxels of a block across the origin, often equal to their neighbours.
fn any_voxels() -> impl Strategy<Value = BTreeMap<[i32; 3], f32>> {
    let log_odds = prop_oneof![9 => Just(0.85_f32), 1 => Just(-0.4)];
    prop::collection::vec(prop::option::weighted(0.97, log_odds), 12 * 12 * 12).prop_map(|block| {
        let key = |i: i32| [i % 12 - 6, i / 12 % 12 - 6, i / 144 - 6];
        (0..).zip(block).filter_map(|(i, l)| Some((key(i), l?))).collect()
    })
}

fn from_map(voxels: &BTreeMap<[i32; 3], f32>) -> Octree {
    // Backwards: the order must not matter.
    Octree::from_voxels(0.01, voxels.iter().rev().map(|(&key, &l)| (IVec3::from_array(key), l))).unwrap()
}

/// The slow twin of expansion: every voxel of every leaf.
fn to_map(tree: &Octree) -> BTreeMap<[i32; 3], f32> {
    let mut voxels = BTreeMap::new();
    for leaf in tree.leaves() {
        let edge = leaf.edge() as i32;
        for i in 0..edge.pow(3) {
            let key = leaf.min + IVec3::new(i % edge, i / edge % edge, i / (edge * edge));
            assert_eq!(voxels.insert(key.to_array(), leaf.log_odds), None, "leaves overlap at {key}");
        }
    }
    voxels
}

proptest! {
    #[test]
    fn bt_files_hold_the_pruned_tree_of_most_likely_occupancies(tree in any_tree(), voxels in any_voxels()) {
        for tree in [tree, from_map(&voxels), from_map(&voxels).pruned()] {
            prop_assert_eq!(bt(&tree), tree.write_bt_slowly());
        }
    }

    #[test]
    fn any_tree_survives_an_ot_file(tree in any_tree()) {
        assert_well_formed(&tree);
        let file = ot(&tree);
        let back = read(&file).unwrap();
        prop_assert_eq!(ot(&back), file);
        prop_assert_eq!(back, tree);
    }

    #[test]
    fn any_bt_file_survives_reading_and_writing(tree in any_tree()) {
        let file = bt(&tree);
        let back = read(&file).unwrap();
        assert_well_formed(&back);
        prop_assert_eq!(bt(&back), file);
    }

    #[test]
    fn voxels_survive_building_pruning_and_expanding(voxels in any_voxels()) {
        let tree = from_map(&voxels);
        assert_well_formed(&tree);
        prop_assert_eq!(tree.n_leaves(), voxels.len());
        prop_assert_eq!(&to_map(&tree), &voxels);
        let pruned = tree.pruned();
        assert_well_formed(&pruned);
        prop_assert_eq!(&to_map(&pruned), &voxels);
        prop_assert_eq!(pruned.expanded(voxels.len()).unwrap(), tree);
    }

    #[test]
    fn bt_keeps_every_voxel_as_free_or_occupied(voxels in any_voxels()) {
        let back = to_map(&read(&bt(&from_map(&voxels))).unwrap());
        prop_assert!(back.keys().eq(voxels.keys()));
        prop_assert!(back.values().zip(voxels.values()).all(|(a, b)| (*a >= 0.0) == (*b >= 0.0)));
    }

    #[test]
    fn a_truncated_file_is_an_error(tree in any_tree(), cut in any::<prop::sample::Index>()) {
        for file in [ot(&tree), bt(&tree)] {
            prop_assert!(read(&file[..cut.index(file.len())]).is_err());
        }
    }

    #[test]
    fn damaged_files_are_errors_or_other_trees(
        tree in any_tree(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        for mut file in [ot(&tree), bt(&tree)] {
            for (at, byte) in &damage {
                let at = at.index(file.len());
                file[at] = *byte;
            }
            if let Ok(tree) = read(&file) {
                assert_well_formed(&tree);
            }
        }
    }

    #[test]
    fn any_bytes_are_an_error_or_a_tree(
        header in prop_oneof![Just(""), Just("OcTree"), Just("ColorOcTree")],
        size in 0..20_u64,
        is_ot in any::<bool>(),
        bytes in prop::collection::vec(prop_oneof![Just(0_u8), any::<u8>()], 0..200),
    ) {
        let magic = if is_ot { "file" } else { "binary file" };
        let header = match header {
            "" => String::new(),
            id => format!("# Octomap OcTree {magic}\nid {id}\nsize {size}\nres 0.1\ndata\n"),
        };
        if let Ok(tree) = read(&[header.as_bytes(), &bytes].concat()) {
            assert_well_formed(&tree);
        }
    }
}

#[test]
fn the_empty_tree_survives_both_files() {
    let empty = Octree::from_voxels(0.1, []).unwrap();
    assert_eq!((empty.n_nodes(), empty.n_leaves(), empty.leaves().count()), (0, 0, 0));
    for file in [ot(&empty), bt(&empty), ot(&empty.pruned()), ot(&empty.expanded(0).unwrap())] {
        assert_eq!(read(&file).unwrap(), empty);
    }
}

/// Checks the error for these node data and its byte offset.
fn check_problem(encoding: Encoding, size: u64, data: &[u8], at: usize, problem: &str) {
    let magic = if encoding == Encoding::Ot { "file" } else { "binary file" };
    let header = format!("# Octomap OcTree {magic}\nid OcTree\nsize {size}\nres 0.1\ndata\n");
    let file = [header.as_bytes(), data].concat();
    assert_eq!(read(&file).unwrap_err(), format!("byte {}: {problem}", header.len() + at));
}

#[test]
fn says_what_is_wrong_with_ot_data_and_where() {
    let check = |size, data: &[u8], at, problem| check_problem(Encoding::Ot, size, data, at, problem);
    let leaf = [0, 0, 0, 0, 0];
    let chain = [0, 0, 0, 0, 1].repeat(17);
    check(1 << 60, &chain[..5], 5, "the data ends after 1 of 1152921504606846976 nodes");
    check(1, b"", 0, "the data ends after 0 of 1 nodes");
    check(1, &leaf[..4], 4, "the data ends after 0 of 1 nodes");
    check(1, &chain[..10], 9, "the tree has more nodes than the size in its header, 1");
    check(2, &leaf, 5, "the tree is complete with 1 nodes, but its header says size 2");
    check(1, &[0; 6], 5, "the tree is complete, expected the file to end here");
    check(0, &leaf, 0, "the tree is complete, expected the file to end here");
    check(17, &chain, 84, "a node at depth 16 has children, expected none below a voxel");
    check(1, &[0, 0, 0xC0, 0x7F, 0], 0, "the log-odds are NaN, expected a finite number");
    check(1, &[0, 0, 0x80, 0xFF, 0], 0, "the log-odds are -inf, expected a finite number");
}

#[test]
fn says_what_is_wrong_with_bt_data_and_where() {
    let check = |size, data: &[u8], at, problem| check_problem(Encoding::Bt, size, data, at, problem);
    check(3, &[0b0111, 0], 2, "the data ends after 1 of 3 nodes");
    check(2, &[0b1001, 0], 0, "the tree has more nodes than the size in its header, 2");
    check(4, &[0b1001, 0], 2, "the tree is complete with 3 nodes, but its header says size 4");
    check(2, &[3, 0, 0, 0], 2, "an inner node at depth 1 has no children, expected at least one");
    check(99, &[3, 0].repeat(20), 30, "a node at depth 16 has children, expected none below a voxel");
}

#[test]
fn bt_leaves_are_octomaps_clamping_values() {
    let tree = read(b"# Octomap OcTree binary file\nid OcTree\nsize 3\nres 0.1\ndata\n\x09\0").unwrap();
    let [free, occupied] = tree.leaves().map(|l| l.log_odds.to_bits()).collect::<Vec<_>>()[..] else {
        panic!("expected two leaves")
    };
    // As written by convert_octree of OctoMap 1.9.7.
    assert_eq!((free, occupied), (0xC000_0075, 0x4060_B4BA));
}
