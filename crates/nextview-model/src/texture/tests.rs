use super::*;
use crate::synthetic_frames::ball;
use crate::{SurfaceMesh, surface_nets};
use glam::{DVec2, IVec3, UVec3};
use nextview::geometry::random::Random;
use nextview::geometry::{Lattice, Pose, VoxelBlock};
use nextview::sensor::ColorImage;
use nextview::view::look_at;

/// Colour of a place on the ball.
fn paint(point: DVec3) -> [f64; 3] {
    [0, 1, 2].map(|k| 128.0 + 70.0 * (40.0 * point[k]).sin())
}

/// Photos of the painted ball from several sides with different brightness, and a mesh of it.
fn painted_ball(gains: &[f64]) -> (SurfaceMesh, Vec<Photo>) {
    let sides = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
    let photos = gains.iter().zip(sides.into_iter().cycle()).map(|(gain, side)| {
        let frame = ball(look_at(0.35 * side + DVec3::Z * 0.1, DVec3::ZERO).unwrap(), 0.1);
        let rotation = frame.world_from_camera().rotation_matrix();
        let pixels = (0..120).flat_map(|v| (0..160).map(move |u| (u, v))).map(|(u, v)| {
            match frame.image().get(u, v) {
                nextview::sensor::Depth::Surface(depth) => {
                    let ideal = frame.intrinsics().deproject(DVec2::new(u.into(), v.into())).unwrap();
                    let point = rotation * (ideal.extend(1.0) * f64::from(depth))
                        + frame.world_from_camera().translation();
                    paint(point).map(|value| (gain * value).round() as u8)
                }
                _ => [0; 3],
            }
        });
        let color = ColorImage::new(160, 120, pixels.collect()).unwrap();
        Photo { frame, color }
    });
    let lattice = Lattice::new(0.008).unwrap();
    let block = VoxelBlock::new(IVec3::splat(-16), UVec3::splat(32)).unwrap();
    let mesh = surface_nets(&lattice, &block, |i| Some(lattice.center(block.key(i)).length() - 0.1));
    (mesh, photos.collect())
}

fn textured(mesh: &SurfaceMesh, photos: &[Photo]) -> TexturedMesh {
    texture_mesh(&mesh.points(), &mesh.triangles, photos, &Cancel::default()).unwrap()
}

/// The texture at a point of a triangle.
fn lookup(mesh: &TexturedMesh, triangle: usize, weights: [f64; 3]) -> [f32; 3] {
    let points = mesh.texture_triangles[triangle].map(|i| mesh.texture_points[i as usize]);
    let at: DVec2 = (0..3).map(|i| weights[i] * points[i]).sum();
    let size = DVec2::new(mesh.texture.width().into(), mesh.texture.height().into());
    let at = DVec2::new(at.x, 1.0 - at.y) * size - 0.5;
    let frame = ball(Pose::IDENTITY, 0.1);
    Photo { frame, color: mesh.texture.clone() }.sample(at.x, at.y)
}

fn random_points(n_triangles: usize) -> impl Iterator<Item = (usize, [f64; 3])> {
    let mut random = Random::new(4, 0);
    (0..2000).map(move |_| {
        let (triangle, a, b) = (random.index(n_triangles), random.unit(), random.unit());
        let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        (triangle, [1.0 - a - b, a, b])
    })
}

/// The slow twin: the point projected into the photo.
#[test]
fn lookups_are_those_of_the_photo() {
    let (mesh, photos) = painted_ball(&[1.0]);
    let shape = ViewedMesh::new(&mesh.vertices, &mesh.triangles);
    let sight = PhotoSight::new(&photos[0], &shape, &Cancel::default()).unwrap();
    let textured = textured(&mesh, &photos);
    let from_world = photos[0].frame.world_from_camera().inverse();
    let mut n_seen = 0;
    for (triangle, weights) in random_points(mesh.triangles.len()) {
        if sight.quality[triangle] == 0.0 {
            continue;
        }
        n_seen += 1;
        let corners = mesh.triangles[triangle].map(|i| mesh.vertices[i as usize]);
        let point: DVec3 = (0..3).map(|i| weights[i] * corners[i]).sum();
        let pixel = photos[0].frame.intrinsics().project(from_world.transform_point(point)).unwrap();
        let expected = photos[0].sample(pixel.x, pixel.y);
        let found = lookup(&textured, triangle, weights);
        for channel in 0..3 {
            assert!((found[channel] - expected[channel]).abs() < 3.0, "{found:?}, expected {expected:?}");
        }
    }
    assert!(n_seen > 400, "{n_seen}");
}

/// The slow twin: the ray of every pixel with every triangle.
#[test]
fn the_depth_of_the_mesh_is_that_of_the_nearest_triangle_on_each_ray() {
    let mut random = Random::new(9, 0);
    let mut corner = || DVec3::new(random.range(-0.2, 0.2), random.range(-0.2, 0.2), random.range(0.3, 0.8));
    let vertices: Vec<DVec3> = (0..60).map(|_| corner()).collect();
    let triangles: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let intrinsics = *ball(Pose::IDENTITY, 0.1).intrinsics();
    let place = |p: &DVec3| Some(sight::ImagePoint { pixel: intrinsics.project(*p).unwrap(), depth: p.z });
    let places: Vec<_> = vertices.iter().map(place).collect();
    let buffer = sight::depth_buffer(&places, &triangles, [160, 120]);
    let mut n_met = 0;
    for (i, depth) in buffer.iter().enumerate() {
        let ideal = intrinsics.deproject(DVec2::new((i % 160) as f64, (i / 160) as f64)).unwrap().extend(1.0);
        let met = triangles.iter().filter_map(|t| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            let normal = (b - a).cross(c - a);
            let depth = normal.dot(a) / normal.dot(ideal);
            let is_in = [(a, b), (b, c), (c, a)]
                .iter()
                .all(|(p, q)| (*q - *p).cross(ideal * depth - *p).dot(normal) >= 0.0);
            is_in.then_some(depth)
        });
        let expected = met.fold(f64::INFINITY, f64::min);
        n_met += usize::from(expected.is_finite());
        assert!(
            *depth == expected || (depth - expected).abs() < 1e-9,
            "pixel {i}: {depth}, expected {expected}"
        );
    }
    assert!(n_met > 2000, "{n_met}");
}

/// The slow twin: rays from points of the triangles to the camera, with every triangle.
#[test]
fn triangles_are_seen_that_nothing_hides() {
    // A ball with a plate in front of part of it.
    let (mut mesh, photos) = painted_ball(&[1.0]);
    let camera = photos[0].frame.world_from_camera();
    let plate = [[-0.03, -0.05], [0.05, -0.05], [0.01, 0.06]].map(|[x, y]| {
        mesh.vertices.push(camera.transform_point(DVec3::new(x, y, 0.15)));
        mesh.vertices.len() as u32 - 1
    });
    mesh.triangles.push([plate[0], plate[2], plate[1]]);
    let shape = ViewedMesh::new(&mesh.vertices, &mesh.triangles);
    let sight = PhotoSight::new(&photos[0], &shape, &Cancel::default()).unwrap();
    let eye = camera.translation();
    let corners = |triangle: usize| mesh.triangles[triangle].map(|i| mesh.vertices[i as usize]);
    // The share of the way to the eye at which the ray from a point first meets another triangle.
    let hidden = |point: DVec3, own: usize| {
        let ray = eye - point;
        let met = (0..mesh.triangles.len()).filter(|i| *i != own).filter_map(|i| {
            let [a, b, c] = corners(i);
            let normal = (b - a).cross(c - a);
            let share = normal.dot(a - point) / normal.dot(ray);
            let at = point + share * ray;
            let is_in =
                [(a, b), (b, c), (c, a)].iter().all(|(p, q)| (*q - *p).cross(at - *p).dot(normal) >= 0.0);
            (is_in && share > 0.0).then_some(share)
        });
        met.fold(0.0, f64::max)
    };
    let (mut n_seen, mut n_hidden, mut n_doubtful) = (0, 0, 0);
    for (triangle, weights) in random_points(mesh.triangles.len() - 1) {
        let point: DVec3 = (0..3).map(|i| weights[i] * corners(triangle)[i]).sum();
        let is_hidden = hidden(point, triangle) * point.distance(eye) > shape.tolerance;
        let [a, b, c] = corners(triangle);
        let cosine = (b - a).cross(c - a).normalize().dot((eye - point).normalize());
        match sight.quality[triangle] > 0.0 {
            true => {
                assert!(!is_hidden && cosine > 0.0, "triangle {triangle} is seen, but {point} is hidden");
                n_seen += 1;
            }
            false if is_hidden || cosine < 0.17 => n_hidden += 1,
            // Next to occluders, and next to the silhouette, some pixels show something else.
            false => n_doubtful += 1,
        }
    }
    assert!(n_seen > 200 && n_hidden > 1000 && n_doubtful < n_seen / 5, "{n_seen}, {n_hidden}, {n_doubtful}");
}

#[test]
fn a_plain_colour_comes_back_exactly() {
    let (mesh, mut photos) = painted_ball(&[1.0, 1.0, 1.0, 1.0]);
    let plain = [211, 84, 33];
    photos
        .iter_mut()
        .for_each(|photo| photo.color = ColorImage::new(160, 120, vec![plain; 160 * 120]).unwrap());
    let mut points = mesh.points();
    points.iter_mut().for_each(|point| point.color = Some(plain));
    let result = texture_mesh(&points, &mesh.triangles, &photos, &Cancel::default()).unwrap();
    for (triangle, weights) in random_points(mesh.triangles.len()) {
        let found = lookup(&result, triangle, weights).map(|value| value.round() as u8);
        assert_eq!(found, plain, "triangle {triangle}");
    }
}

#[test]
fn colours_without_differences_of_exposure_stay_as_they_are() {
    let (mesh, photos) = painted_ball(&[1.0; 4]);
    let shape = ViewedMesh::new(&mesh.vertices, &mesh.triangles);
    let look = |photo: &Photo| PhotoSight::new(photo, &shape, &Cancel::default()).unwrap();
    let sights: Vec<PhotoSight> = photos.iter().map(look).collect();
    let gains = exposure::gains(&photos, &sights, &shape, &Cancel::default()).unwrap();
    for gain in gains.iter().flatten() {
        assert!((gain - 1.0).abs() < 0.01, "{gains:?}");
    }
}

#[test]
fn the_colours_of_a_ball_come_back_although_exposures_differ() {
    let (mesh, photos) = painted_ball(&[1.0, 1.2, 0.9, 1.1]);
    let result = textured(&mesh, &photos);
    let gain = (1.0_f64 * 1.2 * 0.9 * 1.1).powf(0.25);
    let (mut n, mut sum) = (0, 0.0);
    for (triangle, weights) in random_points(mesh.triangles.len()) {
        let corners = mesh.triangles[triangle].map(|i| mesh.vertices[i as usize]);
        let point: DVec3 = (0..3).map(|i| weights[i] * corners[i]).sum();
        // All around, but for the poles.
        if point.z.abs() < 0.04 {
            let (found, expected) = (lookup(&result, triangle, weights), paint(point.normalize() * 0.1));
            sum += (0..3).map(|k| (f64::from(found[k]) - gain * expected[k]).powi(2)).sum::<f64>();
            n += 3;
        }
    }
    let rmse = (sum / f64::from(n)).sqrt();
    assert!(rmse < 6.0, "{rmse}");
}

#[test]
fn one_thread_and_four_give_the_same_bits() {
    let (mesh, photos) = painted_ball(&[1.0, 1.1, 0.9]);
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| textured(&mesh, &photos))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn without_photos_vertices_keep_their_colours() {
    let (mesh, _) = painted_ball(&[1.0]);
    let mut points = mesh.points();
    points.iter_mut().for_each(|point| point.color = Some(paint(point.position).map(|value| value as u8)));
    points[7].color = None;
    let result = texture_mesh(&points, &mesh.triangles, &[], &Cancel::default()).unwrap();
    for (triangle, weights) in random_points(mesh.triangles.len()) {
        let colors = mesh.triangles[triangle].map(|i| points[i as usize].color);
        let [Some(a), Some(b), Some(c)] = colors else { continue };
        let found = lookup(&result, triangle, weights);
        for k in 0..3 {
            let expected: f64 = (0..3).map(|i| weights[i] * f64::from([a, b, c][i][k])).sum();
            assert!((f64::from(found[k]) - expected).abs() < 1.5, "{found:?}");
        }
    }
    let nothing = texture_mesh(&[], &[], &[], &Cancel::default()).unwrap();
    assert_eq!((nothing.texture.width(), nothing.triangles.len()), (1, 0));
}

#[test]
fn faults_are_reported() {
    let (mesh, photos) = painted_ball(&[1.0]);
    let error = |points: &[CloudPoint], triangles: &[[u32; 3]], photos: &[Photo]| {
        texture_mesh(points, triangles, photos, &Cancel::default()).unwrap_err().to_string()
    };
    assert!(error(&mesh.points(), &[[0, 1, 1_000_000]], &[]).contains("1000000"));
    assert!(error(&[DVec3::NAN.into()], &[], &[]).contains("NaN"));
    let color = ColorImage::new(1, 1, vec![[0; 3]]).unwrap();
    let wrong = Photo { color, ..photos[0].clone() };
    assert!(error(&mesh.points(), &mesh.triangles, &[wrong]).contains("1 x 1 pixels"));
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(matches!(
        texture_mesh(&mesh.points(), &mesh.triangles, &photos, &cancel),
        Err(Error::Cancelled(_))
    ));
}

#[test]
fn obj_and_mtl_name_each_other() {
    let mesh = TexturedMesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        texture_points: vec![DVec2::ZERO, DVec2::X, DVec2::Y],
        texture_triangles: vec![[2, 1, 0]],
        texture: ColorImage::new(1, 1, vec![[0; 3]]).unwrap(),
    };
    let (mut obj, mut mtl) = (Vec::new(), Vec::new());
    write_obj(&mut obj, &mesh, "model").unwrap();
    write_mtl(&mut mtl, "model", "model.png").unwrap();
    let obj = String::from_utf8(obj).unwrap();
    assert!(obj.starts_with("mtllib model.mtl\nv 0 0 0\nv 1 0 0\n"), "{obj}");
    assert!(obj.ends_with("vt 0.0000000 1.0000000\nusemtl model\nf 1/3 2/2 3/1\n"), "{obj}");
    assert!(String::from_utf8(mtl).unwrap().ends_with("map_Kd model.png\n"));
    assert!(write_obj(Vec::new(), &mesh, "a\nb").is_err() && write_mtl(Vec::new(), "a", "").is_err());
}
