//! Files go to and from OctoMap's own tools (Debian's package `octomap-tools`) without a byte of difference.

#![allow(clippy::unwrap_used, reason = "clippy exempts the test functions, but not their helpers")]

use glam::{DVec3, IVec3};
use nextview::geometry::Lattice;
use nextview::map::{Integration, OccupancyMap, RayRule, SensorModel};
use nextview_checks::{data, skipped};
use nextview_octomap::Octree;
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::Command;

/// A folder for one test, removed at its end.
struct Scratch(PathBuf);

impl Scratch {
    /// None, with a word on stderr, if the tools are not installed.
    fn with_tools(test: &str, tools: &[&str]) -> Option<Self> {
        for tool in tools {
            if let Err(e) = Command::new(tool).arg("-h").output() {
                assert_eq!(e.kind(), ErrorKind::NotFound, "{tool}: {e}");
                skipped(test, "octomap-tools", format!("{tool} is not installed"));
                return None;
            }
        }
        let folder = std::env::temp_dir().join(format!("nextview-{test}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Some(Self(folder))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// Runs a tool in the folder and returns what it prints.
    fn run(&self, tool: &str, arguments: &[&str]) -> String {
        let output = Command::new(tool).args(arguments).current_dir(&self.0).output().unwrap();
        assert!(output.status.success(), "{tool} {arguments:?}: {output:?}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Nothing to be done if it fails; a second panic would hide the first.
        let _ = fs::remove_dir_all(&self.0);
    }
}

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

fn read(bytes: &[u8]) -> Octree {
    Octree::read(bytes).unwrap()
}

/// A block of occupied voxels with a hole, free space around it and single voxels far away.
fn a_map(voxel_size: f64) -> Octree {
    let block = (0..20 * 20 * 20).map(|i| IVec3::new(i % 20 - 10, i / 20 % 20 - 10, i / 400 - 10));
    let state = |key: IVec3| match key.abs().max_element() {
        0..2 => None,
        2..6 => Some(0.85),
        6..8 => Some(0.405_465_1),
        _ => Some(-0.405_465_1),
    };
    let far = [(IVec3::splat(-32768), 3.5), (IVec3::splat(32767), -2.0), (IVec3::new(0, -9000, 7), 0.0)];
    let voxels = block.filter_map(|key| Some((key, state(key)?))).chain(far);
    Octree::from_voxels(voxel_size, voxels).unwrap()
}

#[test]
fn convert_octree_changes_nothing_in_our_ot_files() {
    let Some(scratch) =
        Scratch::with_tools("convert_octree_changes_nothing_in_our_ot_files", &["convert_octree"])
    else {
        return;
    };
    for voxel_size in [0.01, 0.005, 0.1, 2.0, 1e-5, 2.5e7] {
        for tree in [a_map(voxel_size), a_map(voxel_size).pruned()] {
            scratch.write("ours.ot", ot(&tree));
            scratch.run("convert_octree", &["ours.ot", "theirs.ot"]);
            assert!(scratch.read("theirs.ot") == ot(&tree), "voxel size {voxel_size}");
        }
    }
}

#[test]
fn our_bt_files_are_those_of_convert_octree() {
    let Some(scratch) = Scratch::with_tools("our_bt_files_are_those_of_convert_octree", &["convert_octree"])
    else {
        return;
    };
    let free_only = Octree::from_voxels(0.1, [(IVec3::ZERO, -0.4), (IVec3::ONE, -1.0)]).unwrap();
    for tree in
        [a_map(0.01), a_map(0.01).pruned(), free_only, read(COLORED), read(&ot(&read(COLORED).pruned()))]
    {
        scratch.write("ours.ot", ot(&tree));
        scratch.run("convert_octree", &["ours.ot", "theirs.bt"]);
        let theirs = scratch.read("theirs.bt");
        assert!(theirs == bt(&tree), "another .bt file for {} nodes", tree.n_nodes());
        assert!(bt(&read(&theirs)) == theirs);
    }
}

#[test]
fn bt_files_mean_the_same_to_convert_octree() {
    let Some(scratch) = Scratch::with_tools("bt_files_mean_the_same_to_convert_octree", &["convert_octree"])
    else {
        return;
    };
    let free_only = Octree::from_voxels(0.1, [(IVec3::ZERO, -0.4), (IVec3::ONE, -1.0)]).unwrap();
    for tree in [a_map(0.01), free_only] {
        scratch.write("ours.bt", bt(&tree));
        scratch.run("convert_octree", &["ours.bt", "theirs.ot"]);
        assert!(scratch.read("theirs.ot") == ot(&read(&bt(&tree))));
    }
}

/// A tree with two colours at depth 1.
const COLORED: &[u8] = b"# Octomap OcTree file\n\
    # (feel free to add / change comments, but leave the first line as it is!)\n#\n\
    id ColorOcTree\nsize 3\nres 0.25\ndata\n\
    \0\0\0\x3F\xFF\xFF\xFF\x81\
    \0\0\0\x3F\x01\x02\x03\0\
    \0\0\0\xBF\xFF\xFF\xFF\0";

#[test]
fn colors_survive_convert_octree() {
    let Some(scratch) = Scratch::with_tools("colors_survive_convert_octree", &["convert_octree"]) else {
        return;
    };
    scratch.write("ours.ot", COLORED);
    scratch.run("convert_octree", &["ours.ot", "theirs.ot"]);
    let theirs = scratch.read("theirs.ot");
    assert!(theirs == COLORED && ot(&read(&theirs)) == COLORED);
    let colors: Vec<_> = read(COLORED).leaves().map(|leaf| leaf.color.unwrap()).collect();
    assert_eq!(colors, [[1, 2, 3], [255, 255, 255]]);
}

/// Points on a sphere around the sensor, and a second sensor outside.
fn scan_log() -> String {
    let points: String = (0..3000)
        .map(|i| {
            let (z, angle) = (i as f64 / 1500.0 - 1.0, i as f64 * 2.4);
            let radius = (1.0 - z * z).sqrt();
            format!("{} {} {}\n", 1.3 * radius * angle.cos(), radius * angle.sin(), z)
        })
        .collect();
    format!("NODE 0 0 0.1 0 0 0\n{points}NODE 2.5 0.3 0 0 0 1\n{points}")
}

#[test]
fn maps_made_by_octomap_come_back_byte_for_byte() {
    let Some(scratch) = Scratch::with_tools(
        "maps_made_by_octomap_come_back_byte_for_byte",
        &["log2graph", "graph2tree", "compare_octrees"],
    ) else {
        return;
    };
    scratch.write("scan.log", scan_log());
    scratch.run("log2graph", &["scan.log", "scan.graph"]);
    scratch.run("graph2tree", &["-i", "scan.graph", "-o", "map.bt", "-res", "0.05"]);
    for name in ["map.bt.ot", "map.bt_ml.ot"] {
        assert!(ot(&read(&scratch.read(name))) == scratch.read(name), "{name}");
    }
    let map = read(&scratch.read("map.bt.ot"));
    assert!(bt(&map) == scratch.read("map.bt"));
    assert!(bt(&read(&scratch.read("map.bt"))) == scratch.read("map.bt"));
    check_rebuilding(&scratch, &map);
}

/// OctoMap's map taken apart into voxels and built again is OctoMap's map.
fn check_rebuilding(scratch: &Scratch, map: &Octree) {
    let expanded = map.expanded(1 << 22).unwrap();
    assert!(expanded.n_leaves() > map.n_leaves(), "the map should have merged leaves");
    let voxels = expanded.leaves().map(|leaf| (leaf.min, leaf.log_odds));
    let rebuilt = Octree::from_voxels(map.voxel_size(), voxels).unwrap();
    assert!(rebuilt == expanded);
    assert!(ot(&rebuilt.pruned()) == scratch.read("map.bt.ot"));
    scratch.write("rebuilt.ot", ot(&rebuilt));
    let report = scratch.run("compare_octrees", &["map.bt.ot", "rebuilt.ot"]);
    assert!(report.contains("KLD: 0\n"), "{report}");
}

#[test]
fn any_voxel_size_that_octomap_prints_comes_back() {
    let Some(scratch) =
        Scratch::with_tools("any_voxel_size_that_octomap_prints_comes_back", &["edit_octree"])
    else {
        return;
    };
    scratch.write("ours.bt", bt(&a_map(0.1)));
    for res in ["0.02", "0.0001", "0.00001", "0.3333333333", "3", "123456.7", "123456789"] {
        scratch.run("edit_octree", &["--res", res, "-o", "theirs.bt", "ours.bt"]);
        let theirs = scratch.read("theirs.bt");
        assert!(bt(&read(&theirs)) == theirs, "voxel size {res}");
    }
}

#[test]
fn authors_maps_make_the_same_bt_files() {
    let Some(scratch) = Scratch::with_tools("authors_maps_make_the_same_bt_files", &["convert_octree"])
    else {
        return;
    };
    let Some(data) = data("authors_maps_make_the_same_bt_files", "authors") else { return };
    for name in ["octomap0.ot", "octomap9.ot", "ground_truth_2mm.ot"] {
        let file = fs::read(data.join(name)).unwrap();
        scratch.write("theirs.ot", &file);
        scratch.run("convert_octree", &["theirs.ot", "theirs.bt"]);
        assert!(bt(&read(&file)) == scratch.read("theirs.bt"), "{name}");
    }
}

/// Points of a dented ball, as OctoMap reads them from text, and two sensors outside.
fn two_scans() -> [(DVec3, Vec<DVec3>); 2] {
    let point = |i: usize| {
        let (z, angle) = (i as f64 / 2000.0 - 1.0, i as f64 * 2.399_963);
        let radius = (1.0 - z * z).sqrt() * (1.0 + 0.2 * (5.0 * angle).sin());
        DVec3::new(1.3 * radius * angle.cos(), radius * angle.sin(), z).as_vec3().as_dvec3()
    };
    let facing = |origin: DVec3| (0..4000).map(point).filter(|p| p.dot(origin) > 0.0).collect();
    [DVec3::new(2.53171, 0.31793, 0.17337), DVec3::new(-0.52739, -2.11393, 0.93471)]
        .map(|o| o.as_vec3().as_dvec3())
        .map(|o| (o, facing(o)))
}

/// The same scans make the same map: voxel for voxel, but for rays that pass an edge so closely that
/// OctoMap's single-precision ends decide on which side.
#[test]
fn scans_are_integrated_as_by_octomap() {
    let test = "scans_are_integrated_as_by_octomap";
    let Some(scratch) = Scratch::with_tools(test, &["log2graph", "graph2tree"]) else { return };
    let mut log = String::new();
    for (origin, points) in two_scans() {
        log += &format!("NODE {} {} {} 0 0 0\n", origin.x, origin.y, origin.z);
        points.iter().for_each(|p| log += &format!("{} {} {}\n", p.x, p.y, p.z));
    }
    scratch.write("scan.log", log);
    scratch.run("log2graph", &["scan.log", "scan.graph"]);
    for (rays, option) in [(RayRule::EveryPoint, None), (RayRule::OnePerEndVoxel, Some("-discretize"))] {
        let arguments = ["-g", "-i", "scan.graph", "-o", "theirs.bt", "-res", "0.05"];
        scratch.run("graph2tree", &arguments.into_iter().chain(option).collect::<Vec<_>>());
        let theirs = read(&scratch.read("theirs.bt.ot")).expanded(1 << 22).unwrap();
        let theirs: BTreeMap<[i32; 3], f32> =
            theirs.leaves().map(|leaf| (leaf.min.to_array(), leaf.log_odds)).collect();
        let mut map = OccupancyMap::new(Lattice::new(0.05).unwrap(), SensorModel::default()).unwrap();
        for (origin, points) in two_scans() {
            map.integrate_points(&points, origin, &Integration { rays, ..Integration::default() }).unwrap();
        }
        let ours: BTreeMap<[i32; 3], f32> =
            map.voxels().into_iter().map(|(k, v)| (k.to_array(), v.0)).collect();
        let n_different = ours.iter().filter(|(key, value)| theirs.get(*key) != Some(value)).count()
            + theirs.keys().filter(|key| !ours.contains_key(*key)).count();
        println!("{rays:?}: {} voxels, {} of OctoMap's, {n_different} differ", ours.len(), theirs.len());
        assert!(ours.len() > 20_000 && n_different <= ours.len() / 2000);
    }
}
