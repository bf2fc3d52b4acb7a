//! The recorded maps of the paper's authors, OctoMap `ColorOcTree` files.

#![allow(clippy::unwrap_used, reason = "clippy exempts the test functions, but not their helpers")]

use glam::{DVec3, IVec3};
use nextview::geometry::{Aabb, Lattice, VoxelKey};
use nextview::map::{LogOdds, entropy};
use nextview_checks::data;
use nextview_octomap::{Octree, TreeKind};

#[test]
fn authors_maps_come_back_byte_for_byte() {
    let Some(folder) = data("authors_maps_come_back_byte_for_byte", "authors") else { return };
    let maps = (0..10).map(|i| format!("octomap{i}.ot"));
    let truth = ["ground_truth_1cm.ot", "ground_truth_2mm.ot"].map(String::from);
    for name in maps.chain(truth) {
        let file = std::fs::read(folder.join(&name)).unwrap();
        let tree = Octree::read(&file[..]).unwrap();
        assert_eq!(tree.kind(), TreeKind::ColorOcTree);
        let mut written = Vec::new();
        tree.write_ot(&mut written).unwrap();
        assert!(written == file, "{name} came back changed");
        assert!(tree.pruned().n_leaves() <= tree.n_leaves());
    }
}

/// Occupied voxels (P > 0.65) in the authors' box after each scan, as their code counts them.
const N_OCCUPIED: [usize; 10] = [253, 389, 458, 456, 481, 492, 504, 507, 507, 507];
/// Entropy in the box, nats, as the authors' code sums it.
const ENTROPY: [f64; 10] =
    [4972.79, 4920.26, 4857.12, 4774.21, 4704.43, 4620.32, 4554.41, 4469.47, 4387.50, 4346.05];

#[test]
fn keys_and_log_odds_mean_what_they_mean_to_the_authors() {
    let Some(folder) = data("keys_and_log_odds_mean_what_they_mean_to_the_authors", "authors") else {
        return;
    };
    let views = std::fs::read_to_string(folder.join("candidate_views.txt")).unwrap();
    let mut numbers = views.split_whitespace().skip(1).map(|w| w.parse::<f64>().unwrap());
    let [x, y, z, half_side] = std::array::from_fn(|_| numbers.next().unwrap());
    let aabb = Aabb::cube(DVec3::new(x, y, z), half_side);
    for i in 0..10 {
        let file = std::fs::File::open(folder.join(format!("octomap{i}.ot"))).unwrap();
        let tree = Octree::read(file).unwrap().expanded(1 << 20).unwrap();
        let lattice = Lattice::new(tree.voxel_size()).unwrap();
        let p: Vec<f64> = tree
            .leaves()
            .filter(|leaf| aabb.contains(lattice.center(leaf.min)))
            .map(|leaf| LogOdds(leaf.log_odds).probability())
            .collect();
        assert_eq!(p.len(), 7220, "map {i}");
        assert_eq!(p.iter().filter(|&&p| p > 0.65).count(), N_OCCUPIED[i], "map {i}");
        let sum: f64 = p.iter().map(|&p| entropy(p)).sum();
        assert!((sum - ENTROPY[i]).abs() < 0.006, "map {i}: entropy {sum}, expected {}", ENTROPY[i]);
    }
}

#[test]
fn ground_truth_covers_exactly_the_surface_samples() {
    let Some(folder) = data("ground_truth_covers_exactly_the_surface_samples", "authors") else {
        return;
    };
    let samples = read_samples(&std::fs::read(folder.join("surface_samples.ply")).unwrap());
    for (name, n_voxels) in [("ground_truth_1cm.ot", 526), ("ground_truth_2mm.ot", 11136)] {
        let tree = Octree::read(std::fs::File::open(folder.join(name)).unwrap()).unwrap();
        let lattice = Lattice::new(tree.voxel_size()).unwrap();
        let mut expected: Vec<VoxelKey> = samples.iter().map(|&p| lattice.key(p)).collect();
        let mut actual: Vec<VoxelKey> = tree.expanded(1 << 20).unwrap().leaves().map(|l| l.min).collect();
        for keys in [&mut expected, &mut actual] {
            keys.sort_by_key(IVec3::to_array);
            keys.dedup();
        }
        assert_eq!(actual.len(), n_voxels);
        assert!(actual == expected, "{name} has other voxels than the samples");
    }
}

/// Points in metres from a binary PLY file of three floats in millimetres each.
fn read_samples(ply: &[u8]) -> Vec<DVec3> {
    const END: &[u8] = b"end_header\n";
    let start = ply.windows(END.len()).position(|w| w == END).unwrap() + END.len();
    let number = |bytes: &[u8]| f64::from(f32::from_le_bytes(bytes.try_into().unwrap())) / 1000.0;
    let point = |p: &[u8]| DVec3::new(number(&p[..4]), number(&p[4..8]), number(&p[8..]));
    ply[start..].chunks_exact(12).map(point).collect()
}
