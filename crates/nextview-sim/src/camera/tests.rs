//! Compares the rasteriser with a brute-force reference that intersects every pixel's ray with every
//! triangle.

use super::projection;
use super::*;
use crate::mesh::{Appearance, TriangleMesh};
use glam::{DMat3, DQuat, DVec2, DVec3};
use nextview::geometry::random::Random;
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::{Depth, Distortion, Intrinsics};
use std::sync::Arc;

/// Distance to a triangle's edge, in the plane z = 1, within which reference and rasteriser may differ.
const EDGE: f64 = 1e-9;

/// The reference's intersection along one ray.
struct Crossing {
    depth: f64,
    /// Whether any triangle's edge is close to the ray.
    is_near_edge: bool,
}

/// Intersects a ray from the origin with one triangle (Moeller & Trumbore 1997).
fn intersect(direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<Crossing> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let u = -a.dot(p) / determinant;
    let q = (-a).cross(ab);
    let v = direction.dot(q) / determinant;
    let depth = ac.dot(q) / determinant;
    let margin = [u, v, 1.0 - u - v].into_iter().fold(f64::INFINITY, f64::min);
    // A barycentric margin times an edge of the projection is a distance in the plane z = 1.
    let longest = (ab.length().max(ac.length()) / depth.abs()).max(EDGE);
    let is_near_edge = margin.abs() * longest < EDGE || (depth - projection::MIN_DEPTH).abs() < EDGE;
    (margin > -EDGE && depth > 0.0).then_some(Crossing { depth, is_near_edge })
}

/// Depth of every pixel by brute force; `None` if the nearest intersection is too close to an edge to be
/// certain.
fn brute_force(camera: &SimulatedCamera, world_from_camera: &Pose) -> Vec<Option<f64>> {
    let camera_from_world = world_from_camera.inverse();
    let triangles: Vec<[DVec3; 3]> = (0..camera.mesh().triangles().len())
        .map(|i| camera.mesh().corners(i).map(|v| camera_from_world.transform_point(v)))
        .collect();
    let width = camera.intrinsics().width();
    (0..camera.intrinsics().n_pixels() as u32)
        .map(|i| {
            let pixel = DVec2::new((i % width) as f64, (i / width) as f64);
            let Some(ideal) = camera.intrinsics().deproject(pixel) else { return Some(f64::NAN) };
            let crossings = triangles.iter().filter_map(|&t| intersect(ideal.extend(1.0), t));
            let mut nearest = Crossing { depth: f64::INFINITY, is_near_edge: false };
            for crossing in crossings.filter(|c| c.depth >= projection::MIN_DEPTH - EDGE) {
                if crossing.is_near_edge {
                    return None;
                }
                if crossing.depth < nearest.depth {
                    nearest = crossing;
                }
            }
            Some(nearest.depth)
        })
        .collect()
}

/// Compares and returns the number of pixels that show the mesh.
fn check(camera: &SimulatedCamera, pose: &Pose) -> usize {
    let rendered = camera.render_depth(pose).unwrap();
    let expected = brute_force(camera, pose);
    let n_unclear = expected.iter().filter(|e| e.is_none()).count();
    assert!(n_unclear * 100 <= expected.len(), "{n_unclear} of {} pixels cannot be judged", expected.len());
    for (i, (&actual, expected)) in rendered.iter().zip(expected).enumerate() {
        let Some(expected) = expected else { continue };
        let same = match expected.is_finite() {
            true => (actual as f64 - expected).abs() <= 1e-6 * expected.max(1.0),
            false => actual.is_nan() == expected.is_nan() && !actual.is_finite(),
        };
        assert!(same, "pixel {i} shows {actual}, expected {expected} from {pose:?}");
    }
    rendered.iter().filter(|d| d.is_finite()).count()
}

fn pinhole() -> Intrinsics {
    Intrinsics::pinhole(64, 48, DVec2::new(61.0, 59.0), DVec2::new(30.3, 24.9)).unwrap()
}

/// Small images with and without lens errors; the strong one bends lines by several pixels.
fn optics() -> [Intrinsics; 4] {
    let d435i = Intrinsics::d435i().distortion();
    let strong = Distortion::BrownConrady([-0.25, 0.08, 0.01, -0.02, 0.0]);
    let folding = Distortion::BrownConrady([-2.0, 0.0, 0.0, 0.0, 0.0]);
    [Distortion::None, d435i, strong, folding].map(|d| pinhole().with_distortion(d).unwrap())
}

fn camera(mesh: TriangleMesh, intrinsics: Intrinsics) -> SimulatedCamera {
    SimulatedCamera::new(mesh.into(), intrinsics, Background::None, 1e3).unwrap()
}

fn random_rotation(random: &mut Random) -> DQuat {
    let mut part = || random.range(-1.0, 1.0);
    DQuat::from_xyzw(part(), part(), part(), part()).normalize()
}

/// A pose at `camera_position` that looks towards `target`.
pub(super) fn look_at(camera_position: DVec3, target: DVec3) -> Pose {
    let forward = (target - camera_position).normalize();
    let up = if forward.z.abs() < 0.99 { DVec3::Z } else { DVec3::X };
    let right = forward.cross(up).normalize();
    let basis = DMat3::from_cols(right, forward.cross(right), forward);
    Pose::new(DQuat::from_mat3(&basis), camera_position).unwrap()
}

/// Triangles of all sizes anywhere in a cube of half-side 1, around any camera in it.
fn soup(random: &mut Random, n: usize) -> TriangleMesh {
    let mut vertices = Vec::new();
    for _ in 0..n {
        let (center, size) = (random.in_cube(), random.range(0.0, 1.0).powi(4));
        vertices.extend((0..3).map(|_| center + size * random.in_cube()));
    }
    TriangleMesh::new(vertices, (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()).unwrap()
}

/// A ball of radius 0.1 m with many shared edges and corners.
fn ball(n: u32) -> TriangleMesh {
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..2 * n {
            let (polar, around) = (i as f64 / n as f64, j as f64 / n as f64);
            let (sin_polar, cos_polar) = (std::f64::consts::PI * polar).sin_cos();
            let (sin, cos) = (std::f64::consts::PI * around).sin_cos();
            vertices.push(0.1 * DVec3::new(sin_polar * cos, sin_polar * sin, cos_polar));
        }
    }
    let index = |i: u32, j: u32| i * 2 * n + j % (2 * n);
    let cells = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(vertices, triangles.collect()).unwrap()
}

fn cube(half: f64) -> TriangleMesh {
    let vertices = Aabb::cube(DVec3::ZERO, half).corners().to_vec();
    let quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    TriangleMesh::new(vertices, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
        .unwrap()
}

#[test]
fn agrees_with_brute_force_among_triangles_that_cross_the_camera_plane() {
    let mut random = Random::new(5, 0);
    let mut n_hits = 0;
    for round in 0..40 {
        let camera = camera(soup(&mut random, 120), optics()[round % 4]);
        let pose = Pose::new(random_rotation(&mut random), random.in_cube()).unwrap();
        n_hits += check(&camera, &pose);
    }
    assert!(n_hits > 20_000, "{n_hits}");
}

#[test]
fn agrees_with_brute_force_on_a_closed_surface_from_outside_and_inside() {
    let mut random = Random::new(6, 0);
    for intrinsics in optics() {
        let camera = camera(ball(9), intrinsics);
        for distance in [0.3, 0.15, 0.102, 0.09] {
            let camera_position = random.in_cube().normalize() * distance;
            assert!(check(&camera, &look_at(camera_position, 0.02 * random.in_cube())) > 100);
        }
    }
}

#[test]
fn a_closed_surface_around_the_camera_covers_every_pixel() {
    let mut random = Random::new(7, 0);
    for intrinsics in [Intrinsics::d435i(), pinhole()] {
        let camera = camera(ball(40), intrinsics);
        for _ in 0..20 {
            let pose = Pose::new(random_rotation(&mut random), 0.05 * random.in_cube()).unwrap();
            assert!(camera.render_depth(&pose).unwrap().iter().all(|d| d.is_finite()));
        }
    }
}

#[test]
fn what_is_hidden_changes_no_bit() {
    let (outer, inner) = (ball(30), ball(30).scaled(0.97).unwrap());
    let shift = outer.vertices().len() as u32;
    let vertices = [outer.vertices(), inner.vertices()].concat();
    let shifted = inner.triangles().iter().map(|t| t.map(|v| v + shift));
    let both =
        TriangleMesh::new(vertices, outer.triangles().iter().copied().chain(shifted).collect()).unwrap();
    let mut random = Random::new(9, 0);
    for intrinsics in [Intrinsics::d435i(), pinhole()] {
        let (alone, both) = (camera(outer.clone(), intrinsics), camera(both.clone(), intrinsics));
        for distance in [0.11, 0.2, 0.5] {
            let pose = look_at(random.in_cube().normalize() * distance, 0.02 * random.in_cube());
            let bits = |camera: &SimulatedCamera| -> Vec<u32> {
                camera.render_depth(&pose).unwrap().into_iter().map(f32::to_bits).collect()
            };
            assert_eq!(bits(&alone), bits(&both));
        }
    }
}

/// Edges and corners of the mesh lie exactly on the samples.
#[test]
fn loses_no_pixel_where_edges_and_corners_meet_samples() {
    let intrinsics = Intrinsics::pinhole(64, 64, DVec2::splat(32.0), DVec2::splat(32.0)).unwrap();
    let n = 16;
    let grid = (0..=n).flat_map(|i| (0..=n).map(move |j| DVec2::new(i as f64, j as f64) / 4.0 - 2.0));
    let index = |i: u32, j: u32| i * (n + 1) + j;
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let mesh = TriangleMesh::new(grid.map(|p| p.extend(1.0)).collect(), triangles).unwrap();
    let depth = camera(mesh, intrinsics).render_depth(&Pose::IDENTITY).unwrap();
    assert!(depth.iter().all(|&d| d == 1.0));
}

#[test]
fn the_room_is_seen_behind_the_object_like_a_mesh() {
    let room = Aabb::cube(DVec3::ZERO, 0.6);
    let mut random = Random::new(8, 0);
    for intrinsics in &optics()[..3] {
        let with_room =
            SimulatedCamera::new(ball(9).into(), *intrinsics, Background::Room(room), 10.0).unwrap();
        let (alone, walls) = (camera(ball(9), *intrinsics), camera(cube(0.6), *intrinsics));
        for _ in 0..5 {
            let camera_position = 0.5 * random.in_cube();
            let pose = look_at(camera_position, DVec3::ZERO);
            let (object, wall) = (alone.render_depth(&pose).unwrap(), walls.render_depth(&pose).unwrap());
            for (i, depth) in with_room.render_depth(&pose).unwrap().into_iter().enumerate() {
                let expected = if object[i].is_finite() { object[i] } else { wall[i] };
                assert!((depth - expected).abs() < 1e-6, "pixel {i} shows {depth}, expected {expected}");
            }
        }
    }
}

#[test]
fn gives_the_points_of_a_frame() {
    let camera = camera(ball(20), Intrinsics::d435i());
    let pose = look_at(DVec3::new(0.1, 0.3, 0.2), DVec3::new(0.02, 0.01, 0.0));
    let bounds = Aabb::cube(DVec3::new(0.01, 0.03, 0.0), 0.08);
    let expected: Vec<DVec3> = camera.capture(&pose).unwrap().points_in(bounds).collect();
    assert!(expected.len() > 1000);
    assert_eq!(camera.look(&pose).unwrap().points_in(bounds).collect::<Vec<_>>(), expected);
}

/// The near half of a ball, and nothing outside the image.
#[test]
fn a_look_shows_the_points_that_nothing_hides() {
    let camera = camera(ball(20), Intrinsics::d435i());
    let eye = DVec3::new(0.1, 0.3, 0.2);
    let look = camera.look(&look_at(eye, DVec3::ZERO)).unwrap();
    let surface = crate::mesh::sample_surface(camera.mesh(), 2000, 1);
    let mut n_shown = 0;
    for point in surface {
        // The ball is made of flat triangles: near its horizon, a point may be on either side.
        let facing = point.normalize().dot((eye - point).normalize());
        if facing.abs() > 0.2 {
            assert_eq!(look.shows(point, 0.002), facing > 0.0, "{point}");
            assert!(!look.shows(point + 0.02 * (eye - point), 0.002), "before the surface");
        }
        n_shown += look.shows(point, 0.002) as usize;
        assert!(!look.shows(eye + (eye - point), 0.002), "behind the camera");
    }
    assert!(n_shown > 500);
    let beside = camera.look(&look_at(eye, eye + DVec3::Z)).unwrap();
    assert!(!beside.shows(DVec3::ZERO, 10.0));
}

#[test]
fn surfaces_beyond_the_range_give_nothing_back() {
    let mesh = Arc::new(cube(0.1));
    let pose = look_at(DVec3::new(-0.5, 0.0, 0.0), DVec3::ZERO);
    let seen = |range| {
        let camera = SimulatedCamera::new(mesh.clone(), pinhole(), Background::None, range).unwrap();
        camera.capture(&pose).unwrap().image().get(30, 25)
    };
    assert_eq!(seen(0.41), Depth::Surface(0.4));
    assert_eq!(seen(0.39), Depth::Beyond);
}

#[test]
fn refuses_a_camera_or_an_object_outside_the_room() {
    let small = Background::Room(Aabb::cube(DVec3::ZERO, 0.2));
    assert!(SimulatedCamera::new(cube(0.3).into(), pinhole(), small, 1.0).is_err());
    let camera = SimulatedCamera::new(cube(0.1).into(), pinhole(), small, 1.0).unwrap();
    assert!(camera.capture(&look_at(DVec3::X * 0.15, DVec3::ZERO)).is_ok());
    assert!(camera.capture(&look_at(DVec3::X * 0.2, DVec3::ZERO)).is_err());
    for range in [0.0, f64::NAN, f64::INFINITY] {
        assert!(SimulatedCamera::new(cube(0.1).into(), pinhole(), Background::None, range).is_err());
    }
}

#[test]
fn gives_the_same_bits_in_parallel() {
    use rayon::prelude::*;
    let camera = camera(ball(20), Intrinsics::d435i());
    let pose = |i: usize| look_at(0.4 * nextview::geometry::sphere::fibonacci(i, 12), DVec3::ZERO);
    let bits = |i: usize| -> Vec<u32> {
        camera.render_depth(&pose(i)).unwrap().into_iter().map(f32::to_bits).collect()
    };
    let one_by_one: Vec<Vec<u32>> = (0..12).map(bits).collect();
    let in_parallel: Vec<Vec<u32>> = (0..12).into_par_iter().map(bits).collect();
    assert_eq!(one_by_one, in_parallel);
}

#[test]
fn survives_meshes_at_the_limit_of_the_numbers() {
    let huge = cube(0.1).scaled(1e29).unwrap();
    let pose = look_at(DVec3::new(-0.5, 0.1, 0.2), DVec3::ZERO);
    assert!(camera(huge, pinhole()).render_depth(&pose).unwrap().iter().all(|d| d.is_infinite()));
}

/// The slow reference intersects every pixel's ray with every triangle.
#[test]
fn every_pixel_has_the_colour_of_the_triangle_that_it_shows() {
    let mut random = Random::new(8, 0);
    let mut point = || DVec3::from_array([0, 1, 2].map(|_| random.range(-0.2, 0.2)));
    let vertices: Vec<DVec3> = (0..60).map(|_| point()).collect();
    let triangles: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let vertex_colors = (0..60_u8).map(|i| [4 * (i / 3) + 100, 0, 0]).collect();
    let look = Appearance { vertex_colors, ..Appearance::default() };
    let mesh = Arc::new(TriangleMesh::colored(vertices, triangles, look).unwrap());
    let lens = Distortion::BrownConrady([0.1, -0.05, 0.001, 0.002, 0.0]);
    let optics = Intrinsics::pinhole(61, 47, DVec2::splat(60.0), DVec2::new(30.0, 22.0)).unwrap();
    let optics = optics.with_distortion(lens).unwrap();
    for pose in [DVec3::new(0.5, 0.1, 0.2), DVec3::new(0.05, 0.0, 0.02)]
        .map(|at| Pose::new(DQuat::from_rotation_arc(DVec3::Z, -at.normalize()), at).unwrap())
    {
        let camera = SimulatedCamera::new(mesh.clone(), optics, Background::None, 3.0).unwrap();
        let image = camera.unlit_color(&pose).unwrap().unwrap();
        let to_camera = projection::ToCamera::new(&pose);
        let mut n_compared = 0;
        for (i, ideal) in camera.samples().ideal_points().enumerate() {
            let crossings = (0..mesh.triangles().len()).filter_map(|t| {
                let crossing = intersect(ideal.extend(1.0), mesh.corners(t).map(|c| to_camera.point(c)))?;
                (crossing.depth >= projection::MIN_DEPTH).then_some((crossing, t))
            });
            let nearest = crossings.min_by(|a, b| a.0.depth.total_cmp(&b.0.depth));
            let expected = match &nearest {
                Some((crossing, _)) if crossing.is_near_edge => continue,
                Some((_, triangle)) => [4 * *triangle as u8 + 100, 0, 0],
                None => [0; 3],
            };
            assert_eq!(image.get(i as u32 % 61, i as u32 / 61), expected, "pixel {i}");
            n_compared += usize::from(nearest.is_some());
        }
        assert!(n_compared > 200, "{n_compared}");
    }
}

#[test]
fn light_is_fixed_and_walls_are_grey() {
    let corners = vec![DVec3::ZERO, DVec3::X * 0.2, DVec3::Y * 0.2];
    let look = Appearance { vertex_colors: vec![[255; 3]; 3], ..Appearance::default() };
    let colored = TriangleMesh::colored(corners.clone(), vec![[0, 1, 2]], look).unwrap();
    let optics = Intrinsics::pinhole(64, 48, DVec2::splat(60.0), DVec2::new(31.5, 23.5)).unwrap();
    let room = Background::Room(Aabb::cube(DVec3::ZERO, 1.0));
    let camera = SimulatedCamera::new(Arc::new(colored), optics, room, 3.0).unwrap();
    let above = Pose::new(DQuat::from_rotation_x(std::f64::consts::PI), DVec3::new(0.05, 0.05, 0.5)).unwrap();
    let below = Pose::new(DQuat::IDENTITY, DVec3::new(0.05, 0.05, -0.5)).unwrap();
    let middle = |pose: &Pose| camera.color(pose).unwrap().unwrap().get(32, 24);
    assert_eq!([middle(&above), middle(&below)], [[255; 3], [203; 3]], "0.6 of the light");
    assert_eq!(camera.color(&above).unwrap().unwrap().get(0, 0), [128; 3]);
    let plain = TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
    let camera = SimulatedCamera::new(Arc::new(plain), optics, room, 3.0).unwrap();
    assert_eq!(camera.color(&above).unwrap(), None);
}
