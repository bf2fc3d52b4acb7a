use super::timed_stage::Stage;
use nextview::Cancel;
use nextview::geometry::Lattice;
use nextview::planner::{MaxFlow, MaxFlowConfig};
use nextview::sensor::Intrinsics;
use nextview::session::{Decision, Session, SessionConfig};
use nextview::surface::downsample;
use nextview::view::generate;
use nextview_model::DistanceField;
use nextview_sim::scene::Scene;
use std::hint::black_box;

const VOXEL_SIZE: f64 = 0.005;

/// A whole scan with the defaults of `nextview scan`: 1000 candidates, ten views of a D435i in a room, then
/// cloud and mesh.
pub(super) fn stages() -> Vec<Stage> {
    vec![Stage::new("scan of ten views", "5 mm", 1, |workload| {
        let scene =
            Scene::new((*workload.meshes[0]).clone(), Intrinsics::d435i()).expect("an object of 0.2 m");
        Box::new(move || scan(&scene))
    })]
}

fn scan(scene: &Scene) {
    let views = generate::shell(scene.center(), scene.size(), 1000, 0).expect("a shell around the object");
    let planner = MaxFlow::new(MaxFlowConfig::default()).expect("the defaults are sound");
    let bounds = scene.planning_box(VOXEL_SIZE);
    let config = SessionConfig::new(VOXEL_SIZE, bounds);
    let mut session =
        Session::new(config, Intrinsics::d435i(), views, Box::new(planner)).expect("a sound configuration");
    while let Decision::Move(next) = session.decide().expect("the planner cannot fail") {
        let frame = scene.camera().capture(&next.world_from_camera).expect("a view in the room");
        session.observe(&frame).expect("nobody cancels");
    }
    // The cells of cloud and mesh are those of `nextview scan`.
    let detail = (0.25 * VOXEL_SIZE).max(bounds.longest_side() / 128.0);
    let points = session.frames().iter().flat_map(|frame| frame.points_in(bounds));
    _ = black_box(downsample(points, detail));
    let lattice = Lattice::new(detail).expect("a size written in the source");
    let cells = lattice.block_inside(&bounds).expect("the box is larger than a cell");
    let mut field = DistanceField::new(lattice, cells, 2.0 * detail).expect("a field of few megabytes");
    let never = &Cancel::default();
    session.frames().iter().for_each(|frame| field.integrate(frame, never).expect("nobody cancels"));
    _ = black_box(field.surface(never));
}
