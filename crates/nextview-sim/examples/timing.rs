//! Times the stages of a decision: depth rendering, map update, planning at the paper's and at full ray density.
//!
//!     cargo run --release -p nextview-sim --example timing -- VOXEL_SIZE_M N_CANDIDATES MESH
//!
//! The object is scaled to 0.2 m; candidates are the paper's shell, seed 0. Medians over ten views, one line a stage.

#![allow(clippy::unwrap_used, reason = "an example stops at the first fault")]

use nextview::geometry::Lattice;
use nextview::map::{Background, Integration, OccupancyMap, RayRule, SensorModel};
use nextview::planner::{MaxFlow, MaxFlowConfig, Situation, ViewPlanner};
use nextview::sensor::{Frame, Intrinsics};
use nextview::view::generate;
use nextview::visibility::{FreeSpace, NO_VOXEL_MISSED, RayCaster};
use nextview_sim::mesh::{self, Unit};
use nextview_sim::scene::Scene;
use std::path::Path;
use std::time::Instant;

fn main() {
    let mut args = std::env::args().skip(1);
    let usage = "usage: timing VOXEL_SIZE_M N_CANDIDATES MESH";
    let voxel_size: f64 = args.next().and_then(|text| text.parse().ok()).expect(usage);
    let n_candidates: usize = args.next().and_then(|text| text.parse().ok()).expect(usage);
    let path = args.next().expect(usage);
    let (mesh, _) = mesh::load(Path::new(&path)).unwrap().to_metres(Unit::LongestSide(0.2)).unwrap();
    println!(
        "{path}, {} triangles, voxels of {voxel_size} m, {n_candidates} candidates",
        mesh.triangles().len()
    );
    let scene = Scene::new(mesh, Intrinsics::d435i()).unwrap();
    let views = generate::shell(scene.center(), scene.size(), n_candidates, 0).unwrap();
    let block = Lattice::new(voxel_size).unwrap().block_inside(&scene.planning_box(voxel_size)).unwrap();
    println!("box of {} voxels, {} threads", block.dims(), rayon::current_num_threads());

    let mut frames: Vec<Frame> = Vec::new();
    report("depth image 640 x 480", 10, |i| frames.push(scene.camera().capture(&views.pose(i)).unwrap()));
    let mut map = None;
    for (name, rays, background) in [
        ("map update, every point, background carves", RayRule::EveryPoint, Background::Carve),
        ("map update, every point, object only", RayRule::EveryPoint, Background::Ignore),
        ("map update, per end voxel, object only", RayRule::OnePerEndVoxel, Background::Ignore),
    ] {
        let mut fresh = OccupancyMap::new(Lattice::new(voxel_size).unwrap(), SensorModel::default()).unwrap();
        report(name, 10, |i| {
            _ = fresh
                .integrate(&frames[i], &Integration { rays, background, region: Some(block), ground: None })
        });
        map.get_or_insert(fresh);
    }

    // After three views, in the middle of a scan.
    let mut map = OccupancyMap::new(Lattice::new(voxel_size).unwrap(), SensorModel::default()).unwrap();
    for frame in &frames[..3] {
        map.integrate(frame, &Integration { region: Some(block), ..Integration::default() });
    }
    let snapshot = map.snapshot(block);
    report("snapshot of the box", 5, |_| _ = map.snapshot(block));
    let intrinsics = Intrinsics::d435i();
    let (visited, views, snapshot) = (&[0, 1, 2], &views, &snapshot);
    let situation = Situation {
        snapshot,
        frames: &[],
        views,
        intrinsics: &intrinsics,
        visited,
        history: &[],
        finest_voxel_size: snapshot.lattice().voxel_size(),
    };
    for (density, ray_spacing) in [("the paper's", 10.0), ("full", NO_VOXEL_MISSED)] {
        let caster = RayCaster::new(snapshot, &intrinsics, ray_spacing, FreeSpace::Clear).unwrap();
        let (mut n_rays, mut n_steps) = (0_usize, 0_usize);
        for pose in views.poses() {
            caster.cast(pose, |ray| (n_rays, n_steps) = (n_rays + 1, n_steps + ray.crossings.len()));
        }
        println!("{density} ray density: {n_rays} rays, {n_steps} voxels crossed");
        for (planner, gamma) in [("local", 0.0), ("max-flow", 0.5)] {
            let planner_of =
                MaxFlow::new(MaxFlowConfig { gamma, ray_spacing, ..MaxFlowConfig::default() }).unwrap();
            report(&format!("decision, {planner}, {density} ray density"), 5, |_| {
                _ = planner_of.plan(&situation)
            });
        }
    }
}

fn report(name: &str, n: usize, mut work: impl FnMut(usize)) {
    let mut times: Vec<f64> = (0..n)
        .map(|i| {
            let start = Instant::now();
            work(i);
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("{name:<48} {:>9.2} ms", times[n / 2]);
}
