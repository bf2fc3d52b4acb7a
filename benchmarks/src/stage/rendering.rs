use super::timed_stage::{Stage, TimedWork};
use crate::workload::{N_IMAGES, Workload, intrinsics};
use nextview::sensor::Intrinsics;
use nextview_sim::camera::{Background, SimulatedCamera};
use std::hint::black_box;

/// Depth images of the meshes, by number of triangles relative to the first.
pub(super) fn stages() -> Vec<Stage> {
    let pinhole = (0..3).map(|i| {
        Stage::new("depth image", format!("{}x", 4_usize.pow(i)), N_IMAGES, move |workload| {
            render(workload, i as usize, intrinsics())
        })
    });
    let lens = Stage::new("depth image; D435i lens", "1x", N_IMAGES, |w| render(w, 0, Intrinsics::d435i()));
    pinhole.chain([lens]).collect()
}

fn render(workload: &Workload, mesh: usize, optics: Intrinsics) -> TimedWork<'_> {
    let mesh = workload.meshes[mesh].clone();
    let camera = SimulatedCamera::new(mesh, optics, Background::None, 10.0).expect("a sound camera");
    Box::new(move || {
        for pose in &workload.poses {
            _ = black_box(camera.render_depth(pose));
        }
    })
}
