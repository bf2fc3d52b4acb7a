//! Compares the exact object voxels with those of dense surface samples: numbers, time, memory, and the
//! voxels hit by exact images that are not object voxels.
//!
//!     cargo run --release -p nextview-evidence --bin truth -- [MESH ...]
//!
//! The default is the built-in objects. Voxels are 5 mm; the longest side is 0.15, 0.2 and 0.6 m. Every row
//! is a separate process with its own peak memory.

use nextview::geometry::{Lattice, VoxelBlock};
use nextview::sensor::Intrinsics;
use nextview::view::generate;
use nextview_benchmarks::Outcome;
use nextview_benchmarks::peak_memory_mb;
use nextview_sim::mesh::{self, TriangleMesh, Unit, sample_surface};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use nextview_sim::{SimError, builtin};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const VOXEL_SIZE: f64 = 0.005;
const SIZES: [f64; 3] = [0.15, 0.2, 0.6];

/// Number of samples per voxel face; `None` for the exact voxels.
const METHODS: [Option<usize>; 4] = [Some(16), Some(256), Some(4096), None];

/// Number of samples drawn at a time.
const BATCH: usize = 1 << 20;

/// Number of images that look for voxels.
const N_VIEWS: usize = 40;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, object, size, method] = &arguments[..]
        && flag == "--row"
    {
        return row(&load(object, size.parse()?)?, METHODS[method.parse::<usize>()?]);
    }
    let built_in = || builtin::names().map(|name| format!("builtin:{name}")).collect();
    let objects: Vec<String> = if arguments.is_empty() { built_in() } else { arguments };
    println!("| object | size, m | truth | voxels | time, ms | memory, MB | voxels hit | of them false, % |");
    println!("|---|---:|---|---:|---:|---:|---:|---:|");
    for object in &objects {
        for size in SIZES {
            for (i, method) in METHODS.iter().enumerate() {
                let program = std::env::current_exe()?;
                let [size, i] = [size.to_string(), i.to_string()];
                let row = Command::new(program).args(["--row", object, &size, &i]).output()?;
                if !row.status.success() {
                    return Err(String::from_utf8_lossy(&row.stderr).into());
                }
                let truth = method.map_or("exact".to_owned(), |n| format!("{n} samples per face"));
                let name = object.rsplit(['/', ':']).next().unwrap_or(object);
                println!("| {name} | {size} | {truth} | {} |", String::from_utf8(row.stdout)?.trim());
            }
        }
    }
    Ok(())
}

fn load(object: &str, size: f64) -> Outcome<TriangleMesh> {
    let Some(name) = object.strip_prefix("builtin:") else {
        return Ok(mesh::load(Path::new(object))?.to_metres(Unit::LongestSide(size))?.0);
    };
    let mesh = builtin::by_name(name).ok_or("no such built-in object")?;
    Ok(mesh.scaled(size / mesh.bounds().longest_side())?)
}

/// Prints number of voxels, milliseconds, megabytes, number of voxels hit and share of false ones.
fn row(mesh: &TriangleMesh, samples_per_face: Option<usize>) -> Outcome<()> {
    let lattice = Lattice::new(VOXEL_SIZE)?;
    let bounds = nextview::object::planning_box(&mesh.bounds(), VOXEL_SIZE);
    let block = lattice.block_inside(&bounds).ok_or("no voxels")?;
    let (before, start) = (peak_memory_mb()?, Instant::now());
    let is_object = match samples_per_face {
        Some(n) => sampled(mesh, &lattice, &block, n),
        None => {
            let object = ObjectVoxels::new(mesh, lattice, block);
            (0..block.n_voxels()).map(|index| object.number(block.key(index)).is_some()).collect()
        }
    };
    let (ms, mb) = (1e3 * start.elapsed().as_secs_f64(), peak_memory_mb()? - before);
    let is_hit = hit(mesh, &lattice, &block)?;
    let n_hit = is_hit.iter().filter(|is_hit| **is_hit).count();
    let n_false =
        is_hit.iter().zip(&is_object).filter(|(is_hit, is_object)| **is_hit && !**is_object).count();
    let n = is_object.iter().filter(|is_object| **is_object).count();
    println!("{n} | {ms:.0} | {mb:.0} | {n_hit} | {:.2}", 100.0 * n_false as f64 / n_hit as f64);
    Ok(())
}

/// The voxels of samples of the surface, uniform by area.
fn sampled(mesh: &TriangleMesh, lattice: &Lattice, block: &VoxelBlock, per_face: usize) -> Vec<bool> {
    let face = lattice.voxel_size() * lattice.voxel_size();
    let n = (mesh.area() / face * per_face as f64) as usize;
    let mut is_object = vec![false; block.n_voxels()];
    for (seed, first) in (0..n).step_by(BATCH).enumerate() {
        for point in sample_surface(mesh, BATCH.min(n - first), seed as u64) {
            if let Some(index) = block.index(lattice.key(point)) {
                is_object[index] = true;
            }
        }
    }
    is_object
}

/// The voxels that exact images from all sides hit.
fn hit(mesh: &TriangleMesh, lattice: &Lattice, block: &VoxelBlock) -> Result<Vec<bool>, SimError> {
    let scene = Scene::new(mesh.clone(), Intrinsics::d435i())?;
    let mut is_hit = vec![false; block.n_voxels()];
    for pose in generate::fibonacci_sphere(scene.center(), 3.5 * scene.size(), N_VIEWS)?.poses() {
        for point in scene.camera().look(pose)?.points_in(lattice.bounds(block)) {
            block.index(lattice.key(point)).into_iter().for_each(|index| is_hit[index] = true);
        }
    }
    Ok(is_hit)
}
