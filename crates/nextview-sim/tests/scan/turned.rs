//! Objects that were turned between two scans: is it found how, and refused where it cannot be known?

use crate::common::small_camera;
use glam::{DQuat, DVec3};
use nextview::Cancel;
use nextview::geometry::{Aabb, Plane, Pose};
use nextview::placement::{ShownObject, Turn, TurnRefusal, find_turn};
use nextview::sensor::Frame;
use nextview::session::shown_object;
use nextview::view::generate;
use nextview_sim::builtin;
use nextview_sim::mesh::TriangleMesh;
use nextview_sim::noise::{Noise, SensorNoise};
use nextview_sim::quality::TrueSurface;
use nextview_sim::scene::Scene;
use std::f64::consts::PI;

const VOXEL_SIZE: f64 = 0.005;

/// The object 0.2 m long, in a pose about its middle, with its lowest point on z = 0.
fn laid(name: &str, rotation: DQuat) -> TriangleMesh {
    let mesh = builtin::by_name(name).unwrap_or_else(brick);
    let mesh = mesh.scaled(0.2 / mesh.bounds().longest_side()).unwrap();
    let mesh = mesh.transformed(&Pose::new(rotation, DVec3::ZERO).unwrap()).unwrap();
    let bounds = mesh.bounds();
    mesh.translated(-bounds.center().with_z(bounds.min.z)).unwrap()
}

fn brick() -> TriangleMesh {
    let corners = Aabb { min: DVec3::ZERO, max: DVec3::new(0.2, 0.13, 0.09) }.corners();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    TriangleMesh::new(corners.to_vec(), triangles.collect()).unwrap()
}

/// What eight views from above show of an object on its table.
fn shown(mesh: &TriangleMesh, seed: u64) -> ShownObject {
    let scene = Scene::new(mesh.clone(), small_camera()).unwrap().with_table().unwrap();
    let scene =
        scene.with_noise(Noise { seed, depth: Some(SensorNoise::d435i()), ..Noise::default() }).unwrap();
    let views = generate::fibonacci_sphere(scene.center(), 0.35, 16).unwrap();
    let above = views.poses().iter().filter(|pose| pose.translation().z > 0.05);
    let frames: Vec<Frame> = above.map(|pose| scene.camera().capture(pose).unwrap()).collect();
    let table = Plane::horizontal(0.0).unwrap();
    let bounds = scene.planning_box(VOXEL_SIZE);
    shown_object(&frames, bounds, table, VOXEL_SIZE, &Cancel::default()).unwrap()
}

fn found(before: &TriangleMesh, now: &TriangleMesh) -> Result<Turn, TurnRefusal> {
    find_turn(&shown(before, 1), &shown(now, 2), &Cancel::default()).unwrap()
}

/// Mean distance by which a turn misplaces the surface.
fn error(before: &TriangleMesh, now: &TriangleMesh, turn: &Turn) -> f64 {
    let surface = TrueSurface::new(now);
    let samples = TrueSurface::new(before);
    let distance = |point: &DVec3| surface.distance().at(turn.now_from_before.transform_point(*point));
    samples.samples().iter().map(distance).sum::<f64>() / samples.samples().len() as f64
}

#[test]
fn a_turned_object_is_put_where_it_lies_now() {
    let turns = [
        ("teapot", DQuat::from_rotation_x(PI)),
        ("bracket", DQuat::from_rotation_z(2.0) * DQuat::from_rotation_x(0.5 * PI)),
        ("mug", DQuat::from_rotation_z(-1.0) * DQuat::from_rotation_y(0.5 * PI)),
        // Any of the poses in which a brick is the same is right.
        ("brick", DQuat::from_rotation_z(0.7) * DQuat::from_rotation_x(PI)),
    ];
    for (name, rotation) in turns {
        let (before, now) = (laid(name, DQuat::IDENTITY), laid(name, rotation));
        let turn = found(&before, &now).unwrap_or_else(|refusal| panic!("{name}: {refusal:?}"));
        let error = error(&before, &now, &turn);
        assert!(error < 5e-4, "{name}: {error}, {turn:?}");
    }
}

#[test]
fn what_was_only_turned_about_the_vertical_is_refused() {
    let (before, now) = (laid("bracket", DQuat::IDENTITY), laid("bracket", DQuat::from_rotation_z(1.0)));
    assert_eq!(found(&before, &now), Err(TurnRefusal::NotTurned));
}

#[test]
fn another_object_is_refused() {
    for (before, now) in [("teapot", "mug"), ("bracket", "teapot"), ("mug", "torus-knot")] {
        let found = found(&laid(before, DQuat::IDENTITY), &laid(now, DQuat::from_rotation_x(PI)));
        assert!(found.is_err(), "{before} taken for {now}: {found:?}");
    }
}
