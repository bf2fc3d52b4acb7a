use super::timed_stage::{Stage, TimedWork, name_of};
use crate::network::RayNetwork;
use crate::workload::{N_IMAGES, Set, Workload, intrinsics, ray_spacing_of_image_grid};
use nextview::Cancel;
use nextview::gain::object_probability;
use nextview::map::{Snapshot, frontier};
use nextview::planner::{MaxFlow, MaxFlowConfig, MostSurface, MostSurfaceConfig, Situation, ViewPlanner};
use nextview::visibility::{FreeSpace, NO_VOXEL_MISSED};
use std::hint::black_box;

/// Planning rays with gain, their parts, and whole decisions.
pub(super) fn stages() -> Vec<Stage> {
    use Set::{A, B};
    let sizes = [0.01, 0.005, 0.002];
    let rays = sizes.map(|size| Stage::new("planning rays", name_of(size), 1, move |w| rays(w, size)));
    let object = sizes.map(|size| {
        Stage::new("object probability", name_of(size), 1, move |workload| {
            let snapshot = workload.snapshot(A, size, 3);
            let cancel = Cancel::default();
            Box::new(move || _ = black_box(object_probability(&snapshot, &frontier(&snapshot), &cancel)))
        })
    });
    let flow = [19_177, 148_428].map(|n_rays| {
        Stage::new("flow and cover", format!("{n_rays} rays"), 1, move |workload| {
            let network = RayNetwork::of(workload, n_rays);
            Box::new(move || _ = black_box(network.solve()))
        })
    });
    // In the paper's simulation only rays that hit the object carve; by default all do.
    let decisions = [
        ("decision; rays of the authors' code", A, 0.01, 29.0),
        ("decision; profile paper", A, 0.01, 10.0),
        ("decision; 32 x 24 rays", B, 0.01, ray_spacing_of_image_grid(0.01)),
        ("decision; no voxel missed", B, 0.01, NO_VOXEL_MISSED),
        ("decision; default", B, 0.005, 2.0),
    ]
    .map(|(name, set, size, ray_spacing)| {
        let free_space = if set == A { FreeSpace::Fades } else { FreeSpace::Clear };
        let config = MaxFlowConfig { ray_spacing, free_space, ..MaxFlowConfig::default() };
        Stage::new(name, name_of(size), 1, move |w| max_flow(w.snapshot(set, size, 3), w, config))
    });
    // One image leaves most voxels unknown, and rays long.
    let most_surface =
        [("decision; most-surface; second view", 1), ("decision; most-surface; fourth view", 3)].map(
            |(name, n_images)| {
                Stage::new(name, name_of(0.005), 1, move |workload| {
                    let planner = MostSurface::new(MostSurfaceConfig::default());
                    let planner = planner.expect("the defaults are sound");
                    let visited = (0..n_images).collect();
                    decision(workload.snapshot(B, 0.005, n_images), workload, planner, visited)
                })
            },
        );
    let stages = rays.into_iter().chain(object).chain(flow).chain(decisions);
    stages.chain(most_surface).collect()
}

/// Rays of 5000 views through the map of set A, with only the local gain.
fn rays(workload: &Workload, voxel_size: f64) -> TimedWork<'_> {
    let ray_spacing = ray_spacing_of_image_grid(voxel_size);
    let config =
        MaxFlowConfig { gamma: 0.0, ray_spacing, free_space: FreeSpace::Fades, ..Default::default() };
    max_flow(workload.snapshot(Set::A, voxel_size, N_IMAGES), workload, config)
}

fn max_flow(snapshot: Snapshot, workload: &Workload, config: MaxFlowConfig) -> TimedWork<'_> {
    let planner = MaxFlow::new(config).expect("parameters are written in the source");
    decision(snapshot, workload, planner, Vec::new())
}

fn decision(
    snapshot: Snapshot,
    workload: &Workload,
    planner: impl ViewPlanner + Clone + 'static,
    visited: Vec<usize>,
) -> TimedWork<'_> {
    let (optics, cancel) = (intrinsics(), Cancel::default());
    Box::new(move || {
        let situation = Situation::new(&snapshot, &workload.views, &optics, &cancel);
        let situation = situation.with_visited(&visited).expect("views of the workload were taken");
        // A planner that remembers its plans would do different work each time.
        _ = black_box(planner.clone().plan(&situation));
    })
}
