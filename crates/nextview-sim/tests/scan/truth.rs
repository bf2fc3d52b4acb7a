//! The object voxels: all that a camera finds, none that a dense sampling finds besides, and the same for any
//! threads.

use nextview::geometry::Lattice;
use nextview::sensor::Intrinsics;
use nextview::view::generate;
use nextview_sim::builtin;
use nextview_sim::mesh::{self, TriangleMesh, Unit, sample_surface};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;

const VOXEL_SIZE: f64 = 0.005;

fn object_voxels(mesh: &TriangleMesh, voxel_size: f64) -> ObjectVoxels {
    let lattice = Lattice::new(voxel_size).unwrap();
    let bounds = nextview::object::planning_box(&mesh.bounds(), voxel_size);
    ObjectVoxels::new(mesh, lattice, lattice.block_inside(&bounds).unwrap())
}

/// Number of voxels hit by exact images from twelve sides, and of the false ones among them.
fn hit_and_false(mesh: TriangleMesh) -> [usize; 2] {
    let scene = Scene::new(mesh, Intrinsics::d435i()).unwrap();
    let lattice = Lattice::new(VOXEL_SIZE).unwrap();
    let object = object_voxels(scene.camera().mesh(), VOXEL_SIZE);
    let mut is_hit = vec![false; object.block().n_voxels()];
    let views = generate::fibonacci_sphere(scene.center(), 3.5 * scene.size(), 12).unwrap();
    for pose in views.poses() {
        for point in scene.camera().look(pose).unwrap().points_in(scene.planning_box(VOXEL_SIZE)) {
            object.block().index(lattice.key(point)).into_iter().for_each(|index| is_hit[index] = true);
        }
    }
    let hit = || (0..is_hit.len()).filter(|&index| is_hit[index]);
    [hit().count(), hit().filter(|&index| object.is_false(object.block().key(index))).count()]
}

fn check(name: &str, mesh: TriangleMesh) {
    let [n_hit, n_false] = hit_and_false(mesh);
    assert!(n_hit > 100, "{name}: {n_hit} voxels");
    assert!(n_false == 0, "{name}: {n_false} of {n_hit} voxels are false");
}

#[test]
fn exact_images_of_built_in_objects_hit_no_false_voxels() {
    for name in builtin::names().chain(["random-7", "random-8", "random-9"]) {
        check(name, builtin::by_name(name).unwrap());
    }
}

#[test]
fn exact_images_of_real_objects_hit_no_false_voxels() {
    let name = "exact_images_of_real_objects_hit_no_false_voxels";
    let Some(data) = nextview_checks::data(name, "meshes") else { return };
    let manifest = std::fs::read_to_string(data.join("manifest.csv")).unwrap();
    for line in manifest.lines().skip(1) {
        let name = line.split(',').next().unwrap();
        let (mesh, _) = mesh::load(&data.join(name)).unwrap().to_metres(Unit::LongestSide(0.2)).unwrap();
        check(name, mesh);
    }
}

/// The slow twin, which misses some: the voxels of many random points of the surface.
#[test]
fn the_voxels_of_dense_samples_are_object_voxels() {
    for (name, voxel_size) in [("mug", 0.01), ("bracket", 0.005), ("torus-knot", 0.02)] {
        let mesh = builtin::by_name(name).unwrap();
        let object = object_voxels(&mesh, voxel_size);
        let lattice = Lattice::new(voxel_size).unwrap();
        let n_samples = (400.0 * mesh.area() / voxel_size.powi(2)) as usize;
        let mut is_sampled = vec![false; object.len()];
        for point in sample_surface(&mesh, n_samples, 1) {
            let number = object.number(lattice.key(point));
            is_sampled[number.unwrap_or_else(|| panic!("{name}: {point} is in no object voxel"))] = true;
        }
        let n_sampled = is_sampled.iter().filter(|is_sampled| **is_sampled).count();
        assert!(n_sampled as f64 > 0.95 * object.len() as f64, "{name}: {n_sampled} of {}", object.len());
    }
}

#[test]
fn threads_do_not_show() {
    let mesh = builtin::by_name("teapot").unwrap();
    let numbers = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let object = pool.install(|| object_voxels(&mesh, VOXEL_SIZE));
        let block = object.block();
        (0..block.n_voxels()).map(|index| object.number(block.key(index))).collect::<Vec<_>>()
    };
    assert_eq!(numbers(1), numbers(4));
}
