//! Random objects made from a seed alone, to train and test planners.
//!
//! They resemble nothing in particular, but have the features of real objects: flat and round faces, edges,
//! holes, handles, thin walls, visible insides, and symmetry. The order of the random draws is part of a
//! seed's meaning: changing it changes all objects. [`seeds`] assigns the seeds, so nothing is tested on an
//! object it was trained on.

mod blend;
mod blob;
mod draw;
mod extrusion;
mod lathe;
mod open_box;
pub mod seeds;
mod soup;
mod superellipsoid;
mod tube;

use crate::mesh::TriangleMesh;
use draw::{chance, rotation, upright};
use glam::{DMat3, DVec3};
use nextview::geometry::random::Random;
use soup::Soup;
use std::f64::consts::TAU;

/// The object's longest side, metres.
const SIZE: f64 = 0.2;

/// Separates these draws from others with the same seed.
const STREAM: u64 = 9;

/// Creates the object of this seed: one to six parts grown into each other. In two of five objects all parts
/// but the first have a mirrored twin.
///
/// Parts are superellipsoids (from box to ball, possibly flat, tapered or bent), lathed bodies (bottles,
/// bowls, prisms), tubes (hooks, rings, worms), extruded outlines (gears, plates, stars, some with a hole),
/// blobs, and open boxes.
///
/// The longest side is 0.2 m. The object is centred on the origin and turned at random, in half of all cases
/// about the vertical only; [`by_name`](crate::builtin::by_name) puts it on z = 0.
///
/// Parts overlap, and their surfaces continue inside each other. The view from outside is right, but area and
/// volume of the mesh are not those of the object.
///
/// The same seed gives the same object, except for rounding in the machine's sine and cosine.
///
/// ```
/// use nextview_sim::random_object::random_object;
///
/// let object = random_object(17);
/// assert!((object.bounds().longest_side() - 0.2).abs() < 1e-9);
/// assert_ne!(object, random_object(18));
/// ```
pub fn random_object(seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed, STREAM);
    let parts = grown_parts(&mut random);
    let object = stretched_and_turned(parts, &mut random);
    let mesh =
        TriangleMesh::new(object.vertices, object.triangles).expect("parts are finite and have an area");
    mesh.scaled(SIZE / mesh.bounds().longest_side()).expect("parts are about a metre large")
}

/// Parts in their own size, each but the first around a point of the earlier ones.
fn grown_parts(random: &mut Random) -> Soup {
    let n_parts = 1 + random.index(6);
    let is_symmetric = chance(random, 0.4);
    let mut object = turned_part(random);
    for _ in 1..n_parts {
        let part = turned_part(random);
        let scale = random.range(0.2, 0.9);
        let place = object.vertices[random.index(object.vertices.len())];
        let placed = part.map(|v| place + v * scale);
        let mirrored = is_symmetric.then(|| placed.clone().map(|v| v.with_x(-v.x)));
        object.append(placed);
        mirrored.into_iter().for_each(|twin| object.append(twin));
    }
    object
}

fn turned_part(random: &mut Random) -> Soup {
    let part = part(random);
    let turn = if chance(random, 0.6) { upright(random) } else { rotation(random) };
    part.map(|v| turn * v)
}

/// A part about the origin, with a half-side of about 1.
fn part(random: &mut Random) -> Soup {
    match random.index(10) {
        0..=3 => superellipsoid::make(random),
        4..=5 => lathe::make(random),
        6 => tube::make(random),
        7 => extrusion::make(random),
        8 => blob::make(random),
        _ if chance(random, 0.5) => open_box::make(random),
        _ => extrusion::make(random),
    }
}

fn stretched_and_turned(object: Soup, random: &mut Random) -> Soup {
    let stretch = DVec3::new(random.range(0.6, 1.0), random.range(0.6, 1.0), random.range(0.5, 1.0));
    let turn = match chance(random, 0.5) {
        true => DMat3::from_rotation_z(random.range(0.0, TAU)),
        false => rotation(random),
    };
    object.map(|v| turn * (v * stretch))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use nextview::geometry::Aabb;
    use nextview::sensor::Intrinsics;
    use nextview::view::look_at;

    /// Seed, vertices, triangles including those without an area, and lowest corner of the box in metres.
    type Pinned = (u64, usize, usize, [f64; 3]);

    /// Nothing here depends on the last bits of sine and cosine, which differ between machines.
    #[test]
    fn a_seed_means_the_same_object_for_ever() {
        for (seed, n_vertices, n_triangles, min) in PINNED {
            let mesh = random_object(seed);
            assert_eq!(mesh.vertices().len(), n_vertices, "seed {seed}");
            assert_eq!(mesh.triangles().len() + mesh.n_degenerate(), n_triangles, "seed {seed}");
            let bounds = mesh.bounds();
            assert!(bounds.min.abs_diff_eq(min.into(), 1e-9), "seed {seed}: {bounds:?}");
        }
    }

    #[test]
    fn objects_are_of_the_stated_size_and_can_be_seen() {
        for seed in 0..100 {
            let mesh = random_object(seed);
            assert!(mesh.vertices().iter().all(|v| v.is_finite()), "seed {seed}");
            assert!((mesh.bounds().longest_side() - SIZE).abs() < 1e-12, "seed {seed}: {:?}", mesh.bounds());
            assert!((500..50_000).contains(&mesh.triangles().len()), "seed {seed}");
            assert!(n_pixels_of(mesh) > 5000, "seed {seed}");
        }
    }

    /// Pixels that show the object, from three times its half-side.
    fn n_pixels_of(mesh: TriangleMesh) -> usize {
        let bounds = mesh.bounds();
        let scene = Scene::new(mesh, Intrinsics::d435i()).unwrap();
        let position = scene.center() + scene.size() * DVec3::new(2.0, 2.0, 1.0);
        let frame = scene.camera().capture(&look_at(position, scene.center()).unwrap()).unwrap();
        frame.points_in(Aabb { min: bounds.min - 1e-3, max: bounds.max + 1e-3 }).count()
    }

    /// A superellipsoid, a turned body, a tube, an extruded outline, a blob, an open box; several parts.
    const PINNED: [Pinned; 7] = [
        (6, 1617, 3072, [-0.0798552843, -0.1021963388, -0.0215135961]),
        (124, 1323, 2496, [-0.0763285517, -0.0600852160, -0.0842811110]),
        (40, 1225, 2304, [-0.0183372800, -0.1080460703, -0.0536756235]),
        (255, 629, 1152, [-0.0981173798, -0.0895033623, -0.0446942629]),
        (2, 2145, 4096, [-0.0361553559, -0.1016382163, -0.0318921936]),
        (3, 2430, 3840, [-0.0840090409, -0.0802387706, -0.1000000000]),
        (0, 8594, 16256, [-0.1074840707, -0.0927630701, -0.0725662806]),
    ];
}
