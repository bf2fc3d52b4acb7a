//! Scans of shapes with a formula: what the surface model makes of them.

#![allow(clippy::unwrap_used, reason = "helpers of a test")]

use glam::{DVec2, DVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::{Aabb, Lattice, Plane, Pose, VoxelBlock, sphere};
use nextview::sensor::{DepthImage, Distortion, Frame, Intrinsics};
use nextview::view::look_at;
use nextview_model::{DistanceField, Floor, SurfaceMesh, WatertightMesh};
use std::collections::BTreeMap;

const VOXEL: f64 = 0.004;
const RADIUS: f64 = 0.06;

/// A shape: where the ray `origin + t * direction` first meets it.
type Shape = fn(DVec3, DVec3) -> Option<f64>;

fn ball(origin: DVec3, direction: DVec3) -> Option<f64> {
    let (a, half_b) = (direction.length_squared(), origin.dot(direction));
    let discriminant = half_b * half_b - a * (origin.length_squared() - RADIUS * RADIUS);
    (discriminant >= 0.0).then(|| (-half_b - discriminant.sqrt()) / a)
}

fn cuboid(half: DVec3, origin: DVec3, direction: DVec3) -> Option<f64> {
    Aabb { min: -half, max: half }.clip(origin, direction, 10.0).map(|(t_in, _)| t_in)
}

/// Not aligned with the voxels, so that no face falls on voxel centres.
const CUBE_HALF: f64 = 0.0507;

fn cube(origin: DVec3, direction: DVec3) -> Option<f64> {
    cuboid(DVec3::splat(CUBE_HALF), origin, direction)
}

/// Two voxels thick.
fn plate(origin: DVec3, direction: DVec3) -> Option<f64> {
    cuboid(DVec3::new(0.05, 0.05, VOXEL), origin, direction)
}

fn pinhole() -> Intrinsics {
    Intrinsics::pinhole(320, 240, DVec2::splat(300.0), DVec2::new(159.5, 119.5)).unwrap()
}

/// A frame of the shape; what is beside it is `beside` metres away.
fn render(shape: Shape, camera: Intrinsics, world_from_camera: Pose, beside: f32) -> Frame {
    let (rotation, origin) = (world_from_camera.rotation_matrix(), world_from_camera.translation());
    let depth = (0..camera.n_pixels())
        .map(|i| {
            let pixel =
                DVec2::new((i % camera.width() as usize) as f64, (i / camera.width() as usize) as f64);
            // The third component is 1, so that the ray's parameter is depth.
            let ideal = camera.deproject(pixel).unwrap();
            shape(origin, rotation * ideal.extend(1.0)).map_or(beside, |t| t as f32)
        })
        .collect();
    let image = DepthImage::from_metres(camera.width(), camera.height(), depth).unwrap();
    Frame::new(image, camera, world_from_camera, 2.0).unwrap()
}

fn empty_field() -> DistanceField {
    let lattice = Lattice::new(VOXEL).unwrap();
    let block = lattice.block_inside(&Aabb::cube(DVec3::ZERO, 0.08)).unwrap();
    DistanceField::new(lattice, block, 2.0 * VOXEL).unwrap()
}

/// The field after looks at the shape from these directions.
fn scan(shape: Shape, directions: impl IntoIterator<Item = DVec3>) -> DistanceField {
    let mut field = empty_field();
    for direction in directions {
        let pose = look_at(0.4 * direction, DVec3::ZERO).unwrap();
        field.integrate(&render(shape, pinhole(), pose, f32::INFINITY), &Cancel::default()).unwrap();
    }
    field
}

fn around(n: usize) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |i| sphere::fibonacci(i, n))
}

/// How often each edge is used, in the direction of its triangle.
fn directed_edges(mesh: &SurfaceMesh) -> BTreeMap<(u32, u32), usize> {
    let mut edges = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    edges
}

/// Every edge belongs to two triangles, which use it in opposite directions.
fn assert_watertight(mesh: &SurfaceMesh) {
    let edges = directed_edges(mesh);
    assert!(!edges.is_empty());
    for (&(a, b), &n) in &edges {
        assert_eq!((n, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
    }
}

fn euler_characteristic(mesh: &SurfaceMesh) -> isize {
    let n_edges = directed_edges(mesh).keys().filter(|(a, b)| a < b).count();
    mesh.vertices.len() as isize - n_edges as isize + mesh.triangles.len() as isize
}

fn volume(mesh: &SurfaceMesh) -> f64 {
    let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize]));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn area(mesh: &SurfaceMesh) -> f64 {
    let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize]));
    corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

/// Mean and maximum of a distance over all vertices, in voxels.
fn mean_and_max(mesh: &SurfaceMesh, distance: impl Fn(DVec3) -> f64) -> (f64, f64) {
    let distances: Vec<f64> = mesh.vertices.iter().map(|&v| distance(v).abs() / VOXEL).collect();
    assert!(distances.iter().all(|d| d.is_finite()));
    let max = distances.iter().copied().fold(0.0, f64::max);
    (distances.iter().sum::<f64>() / distances.len() as f64, max)
}

/// The slow twin: a field for every voxel.
#[test]
fn voxels_together_are_as_many_fields_of_one() {
    let lattice = Lattice::new(VOXEL).unwrap();
    let block =
        lattice.block_inside(&Aabb { min: -DVec3::new(0.07, 0.05, 0.03), max: DVec3::splat(0.075) }).unwrap();
    let lens = Distortion::BrownConrady([-0.1, 0.02, 0.001, -0.002, 0.0]);
    for (camera, beside) in [(pinhole(), f32::INFINITY), (pinhole().with_distortion(lens).unwrap(), 1.0)] {
        let pose = |direction| look_at(0.3 * direction, DVec3::ZERO).unwrap();
        let frames: Vec<Frame> =
            around(3).map(|direction| render(cube, camera, pose(direction), beside)).collect();
        let field = |block| {
            let mut field = DistanceField::new(lattice, block, 2.0 * VOXEL).unwrap();
            frames.iter().for_each(|frame| field.integrate(frame, &Cancel::default()).unwrap());
            field
        };
        let whole = field(block);
        for voxel in (0..block.n_voxels()).step_by(97).map(|i| block.key(i)) {
            let alone = field(VoxelBlock::new(voxel, UVec3::ONE).unwrap());
            assert_eq!(whole.distance(voxel), alone.distance(voxel), "{voxel}");
        }
    }
}

#[test]
fn a_ball_seen_from_all_sides_is_closed_and_in_place() {
    let mesh = scan(ball, around(12)).surface(&Cancel::default()).unwrap();
    let (mean, max) = mean_and_max(&mesh, |v| v.length() - RADIUS);
    assert!(mean < 0.05 && max < 0.3, "{mean} {max} voxels");
    assert_watertight(&mesh);
    assert_eq!(euler_characteristic(&mesh), 2);
    let expected = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    assert!((volume(&mesh) / expected - 1.0).abs() < 0.01, "{}", volume(&mesh) / expected);
}

#[test]
fn a_cube_keeps_its_faces_and_rounds_its_edges() {
    let mesh = scan(cube, around(12)).surface(&Cancel::default()).unwrap();
    let distance = |v: DVec3| {
        let beyond = v.abs() - CUBE_HALF;
        beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
    };
    let on_face =
        |v: DVec3| (v.abs().cmpgt(DVec3::splat(CUBE_HALF - 2.0 * VOXEL))).bitmask().count_ones() == 1;
    let (mean, max) = mean_and_max(&mesh, distance);
    let flat = SurfaceMesh {
        vertices: mesh.vertices.iter().copied().filter(|&v| on_face(v)).collect(),
        ..Default::default()
    };
    let (_, flat_max) = mean_and_max(&flat, distance);
    assert!(mean < 0.05 && flat_max < 0.05 && max < 0.3, "{mean} {flat_max} {max} voxels");
    assert_watertight(&mesh);
    assert_eq!(euler_characteristic(&mesh), 2);
    assert!((volume(&mesh) / (2.0 * CUBE_HALF).powi(3) - 1.0).abs() < 0.02);
}

#[test]
fn a_ball_seen_from_one_side_is_an_open_cap() {
    let mesh = scan(ball, [DVec3::X]).surface(&Cancel::default()).unwrap();
    let (_, max) = mean_and_max(&mesh, |v| v.length() - RADIUS);
    assert!(max < 0.3, "{max} voxels");
    assert!(mesh.vertices.len() > 500 && mesh.vertices.iter().all(|v| v.x > 0.0), "nothing behind");
    let edges = directed_edges(&mesh);
    assert!(edges.keys().any(|&(a, b)| !edges.contains_key(&(b, a))), "open");
    for &[a, b, c] in &mesh.triangles {
        let [a, b, c] = [a, b, c].map(|i| mesh.vertices[i as usize]);
        assert!((b - a).cross(c - a).dot(a) > 0.0, "turned inward");
    }
}

#[test]
fn a_plate_of_two_voxels_keeps_both_sides() {
    let mesh = scan(plate, around(12)).surface(&Cancel::default()).unwrap();
    let inner = mesh.vertices.iter().filter(|v| v.truncate().abs().max_element() < 0.045);
    let (mut up, mut down) = (0, 0);
    for v in inner {
        assert!((v.z.abs() - VOXEL).abs() < 0.3 * VOXEL, "{v}");
        *(if v.z > 0.0 { &mut up } else { &mut down }) += 1;
    }
    assert!(up > 350 && down > 350, "{up} {down}");
    assert!(mesh.vertices.iter().all(|v| v.truncate().abs().max_element() < 0.05 + VOXEL), "no fringe");
    assert_watertight(&mesh);
    let ratio = volume(&mesh) / (0.1 * 0.1 * 2.0 * VOXEL);
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

#[test]
fn a_wall_in_the_background_is_as_good_as_nothing() {
    let mut field = empty_field();
    for direction in around(12) {
        field
            .integrate(
                &render(ball, pinhole(), look_at(0.4 * direction, DVec3::ZERO).unwrap(), 1.0),
                &Cancel::default(),
            )
            .unwrap();
    }
    let mesh = field.surface(&Cancel::default()).unwrap();
    let (mean, max) = mean_and_max(&mesh, |v| v.length() - RADIUS);
    assert!(mean < 0.05 && max < 0.3, "{mean} {max} voxels");
    assert_watertight(&mesh);
    assert_eq!(euler_characteristic(&mesh), 2);
}

/// As behind a mask that is too tight: where a frame shows the ball at its rim, nothing seems to be.
#[test]
fn masks_that_are_too_tight_do_not_carve_away_what_other_frames_measured() {
    let mut field = empty_field();
    let camera = pinhole();
    for direction in around(24) {
        let pose = look_at(0.4 * direction, DVec3::ZERO).unwrap();
        let tight = |origin: DVec3, ray: DVec3| {
            let nearest = origin + ray * (-origin.dot(ray) / ray.length_squared());
            ball(origin, ray).filter(|_| nearest.length() < 0.93 * RADIUS)
        };
        field.integrate(&render(tight, camera, pose, f32::INFINITY), &Cancel::default()).unwrap();
    }
    let mesh = field.surface(&Cancel::default()).unwrap();
    let (mean, max) = mean_and_max(&mesh, |v| v.length() - RADIUS);
    assert!(mean < 0.1 && max < 0.5, "{mean} {max} voxels");
    let expected = 4.0 * std::f64::consts::PI * RADIUS.powi(2);
    assert!((area(&mesh) / expected - 1.0).abs() < 0.03, "{}", area(&mesh) / expected);
}

/// The ball, and a table that it stands on.
fn ball_on_table(origin: DVec3, direction: DVec3) -> Option<f64> {
    let table = (-RADIUS - origin.z) / direction.z;
    ball(origin, direction).or((table > 0.0).then_some(table))
}

#[test]
fn what_is_not_above_the_top_of_a_table_is_no_surface_but_ends_free_rays() {
    let mesh_above = |top: Option<Plane>| {
        let mut field = empty_field();
        for direction in around(24).filter(|direction| direction.z > 0.2) {
            let pose = look_at(0.4 * direction, DVec3::ZERO).unwrap();
            let frame = render(ball_on_table, pinhole(), pose, f32::INFINITY);
            field.integrate_above(&frame, top, &Cancel::default()).unwrap();
        }
        let beside = field.lattice().key(DVec3::new(0.07, 0.07, -0.03));
        assert_eq!(field.distance(beside), Some(2.0 * VOXEL as f32), "free before the table");
        field.surface(&Cancel::default()).unwrap()
    };
    let off_the_ball = |mesh: &SurfaceMesh| mean_and_max(mesh, |v| v.length() - RADIUS).1;
    assert!(off_the_ball(&mesh_above(None)) > 5.0, "the table, voxels");
    let top = Plane::horizontal(VOXEL - RADIUS).unwrap();
    let mesh = mesh_above(Some(top));
    assert!(off_the_ball(&mesh) < 0.3, "{} voxels", off_the_ball(&mesh));
    let expected = 2.0 * std::f64::consts::PI * RADIUS * (RADIUS + 0.5 * RADIUS);
    assert!(area(&mesh) > expected, "{} {expected}", area(&mesh));
}

#[test]
fn missing_pixels_leave_holes_and_make_no_surface() {
    let mut field = empty_field();
    for direction in around(12) {
        field
            .integrate(
                &render(ball, pinhole(), look_at(0.4 * direction, DVec3::ZERO).unwrap(), f32::NAN),
                &Cancel::default(),
            )
            .unwrap();
    }
    let (_, max) = mean_and_max(&field.surface(&Cancel::default()).unwrap(), |v| v.length() - RADIUS);
    assert!(max < 0.3, "{max} voxels");
    field = empty_field();
    field
        .integrate(
            &render(|_, _| None, pinhole(), look_at(DVec3::X * 0.4, DVec3::ZERO).unwrap(), f32::NAN),
            &Cancel::default(),
        )
        .unwrap();
    assert_eq!(field.distance(glam::IVec3::ZERO), None);
}

#[test]
fn a_lens_does_not_show() {
    let strong = Distortion::BrownConrady([-0.2, 0.05, 0.01, -0.01, 0.0]);
    for camera in [pinhole().with_distortion(strong).unwrap(), Intrinsics::d435i()] {
        let mut field = empty_field();
        for direction in around(12) {
            field
                .integrate(
                    &render(ball, camera, look_at(0.3 * direction, DVec3::ZERO).unwrap(), f32::INFINITY),
                    &Cancel::default(),
                )
                .unwrap();
        }
        let mesh = field.surface(&Cancel::default()).unwrap();
        let (_, max) = mean_and_max(&mesh, |v| v.length() - RADIUS);
        assert!(max < 0.3, "{max} voxels");
        assert_watertight(&mesh);
    }
}

/// The closed surface: without border, turned outwards, and beside what was filled in as it was measured.
fn closed(field: &DistanceField, floor: Option<&Floor>) -> WatertightMesh {
    let closed = field.watertight_surface(floor, &Cancel::default()).unwrap();
    assert_watertight(&closed.mesh);
    assert!(volume(&closed.mesh) > 0.0 && closed.is_filled.len() == closed.mesh.vertices.len());
    closed
}

const BALL_VOLUME: f64 = 4.0 / 3.0 * std::f64::consts::PI * RADIUS * RADIUS * RADIUS;

#[test]
fn a_ball_seen_from_all_sides_needs_no_filling() {
    let field = scan(ball, around(12));
    let found = closed(&field, None);
    assert_eq!(found.mesh, field.surface(&Cancel::default()).unwrap());
    assert_eq!((found.filled_share(), found.measured()), (0.0, found.mesh));
}

#[test]
fn a_ball_seen_from_three_sides_is_closed_smoothly() {
    let field = scan(ball, [DVec3::X, DVec3::new(-0.5, 0.8, 0.0), DVec3::new(-0.5, -0.8, 0.0)]);
    let found = closed(&field, None);
    let (mean, max) = mean_and_max(&found.mesh, |v| v.length() - RADIUS);
    assert_eq!(euler_characteristic(&found.mesh), 2);
    assert!((volume(&found.mesh) / BALL_VOLUME - 1.0).abs() < 0.03);
    assert!(mean < 0.3 && max < 3.0, "{mean} {max} voxels");
    assert!((0.0..0.15).contains(&found.filled_share()), "{}", found.filled_share());
    // What was measured is as in the open mesh, but for the triangles of quads that are filled by half.
    let (measured, open) = (found.measured(), field.surface(&Cancel::default()).unwrap());
    let (measured, open) = (area(&measured), area(&open));
    assert!((measured / open - 1.0).abs() < 0.02, "{measured} {open}");
}

#[test]
fn a_ball_seen_from_one_side_becomes_a_solid_cap() {
    let found = closed(&scan(ball, [DVec3::X]), None);
    let share = volume(&found.mesh) / BALL_VOLUME;
    assert!((0.2..1.5).contains(&share) && (0.2..0.8).contains(&found.filled_share()), "{share}");
}

/// An open box: its inside was seen from above, its bottom never.
fn open_box(origin: DVec3, direction: DVec3) -> Option<f64> {
    let (outer, wall) = (DVec3::new(0.05, 0.05, 0.04), 0.0121);
    let walls = [
        (DVec3::new(-outer.x, -outer.y, -outer.z), DVec3::new(outer.x, outer.y, wall - outer.z)),
        (DVec3::new(-outer.x, -outer.y, -outer.z), DVec3::new(wall - outer.x, outer.y, outer.z)),
        (DVec3::new(outer.x - wall, -outer.y, -outer.z), DVec3::new(outer.x, outer.y, outer.z)),
        (DVec3::new(-outer.x, -outer.y, -outer.z), DVec3::new(outer.x, wall - outer.y, outer.z)),
        (DVec3::new(-outer.x, outer.y - wall, -outer.z), DVec3::new(outer.x, outer.y, outer.z)),
    ];
    let hits = walls.into_iter().filter_map(|(min, max)| Aabb { min, max }.clip(origin, direction, 10.0));
    hits.map(|(t_in, _)| t_in).min_by(f64::total_cmp)
}

#[test]
fn an_open_box_stays_open_and_gets_a_bottom() {
    let above = around(40).filter(|direction| direction.z > 0.1);
    let plane = Plane::horizontal(-0.04).unwrap();
    let floor = Floor { plane, clearance: 0.002 };
    let field = scan(
        |origin, direction| {
            let table = (-0.04 - origin.z) / direction.z;
            [open_box(origin, direction), (table > 0.0).then_some(table)]
                .into_iter()
                .flatten()
                .min_by(f64::total_cmp)
        },
        above,
    );
    let found = closed(&field, Some(&floor));
    assert_eq!(euler_characteristic(&found.mesh), 2, "no handles");
    let bottom: Vec<&DVec3> = found.mesh.vertices.iter().filter(|v| v.z < -0.0385).collect();
    let inner = bottom.iter().filter(|v| v.truncate().abs().max_element() < 0.045);
    assert!(inner.clone().count() > 300 && inner.clone().all(|v| (v.z + 0.04).abs() < 1e-6), "a flat bottom");
    let expected = 0.1 * 0.1 * 0.08 - 0.0758 * 0.0758 * (0.08 - 0.0121);
    let share = volume(&found.mesh) / expected;
    assert!((share - 1.0).abs() < 0.05, "{share}");
}

/// The block ends inside the ball: so does the solid.
#[test]
fn what_reaches_the_border_of_the_block_ends_there() {
    let lattice = Lattice::new(VOXEL).unwrap();
    let half = Aabb { min: DVec3::new(-0.08, -0.08, 0.0), max: DVec3::splat(0.08) };
    let block = lattice.block_inside(&half).unwrap();
    let mut field = DistanceField::new(lattice, block, 2.0 * VOXEL).unwrap();
    for direction in around(12) {
        let pose = look_at(0.4 * direction, DVec3::ZERO).unwrap();
        field.integrate(&render(ball, pinhole(), pose, f32::INFINITY), &Cancel::default()).unwrap();
    }
    let found = closed(&field, None);
    assert!((volume(&found.mesh) / (0.5 * BALL_VOLUME) - 1.0).abs() < 0.02, "{}", volume(&found.mesh));
    assert!(found.mesh.vertices.iter().all(|v| v.z > -1e-9));
    assert!(found.mesh.vertices.iter().filter(|v| v.z < 1e-9).count() > 500);
}

#[test]
fn nothing_seen_is_no_closed_surface() {
    let nothing = |field: DistanceField| field.watertight_surface(None, &Cancel::default()).unwrap();
    assert_eq!(nothing(empty_field()), WatertightMesh::default());
    assert_eq!(nothing(scan(|_, _| None, around(3))), WatertightMesh::default());
    assert_eq!(WatertightMesh::default().filled_share(), 0.0);
}

#[test]
fn nothing_seen_is_no_surface() {
    assert_eq!(empty_field().surface(&Cancel::default()).unwrap(), SurfaceMesh::default());
    assert_eq!(scan(|_, _| None, around(3)).surface(&Cancel::default()).unwrap(), SurfaceMesh::default());
    let mut behind = empty_field();
    behind
        .integrate(
            &render(ball, pinhole(), look_at(DVec3::X * 0.4, DVec3::X).unwrap(), 1.0),
            &Cancel::default(),
        )
        .unwrap();
    assert_eq!(behind.surface(&Cancel::default()).unwrap(), SurfaceMesh::default());
    let mut inside = empty_field();
    inside
        .integrate(
            &render(|_, _| None, pinhole(), look_at(DVec3::ZERO, DVec3::X).unwrap(), 1.0),
            &Cancel::default(),
        )
        .unwrap();
    assert_eq!(inside.surface(&Cancel::default()).unwrap(), SurfaceMesh::default());
}

#[test]
fn refuses_what_is_no_field() {
    let (lattice, block) = (empty_field().lattice(), empty_field().block());
    for truncation in [0.0, VOXEL, -1.0, f64::NAN, f64::INFINITY] {
        assert!(DistanceField::new(lattice, block, truncation).is_err(), "{truncation}");
    }
    let huge = VoxelBlock::new(glam::IVec3::ZERO, UVec3::splat(812)).unwrap();
    let error = DistanceField::new(lattice, huge, 2.0 * VOXEL).unwrap_err().to_string();
    assert!(error.contains("more than the limit of 4096 MB"), "{error}");
}

#[test]
fn threads_do_not_show() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let field = pool.install(|| scan(cube, around(5)));
        pool.install(|| (field.surface(&Cancel::default()).unwrap(), closed(&field, None)))
    };
    assert_eq!(run(1), run(4));
}
