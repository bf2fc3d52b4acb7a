//! Objects that need no file, for examples, tests and a first look: 0.15 to 0.2 m large, standing on z = 0,
//! centred in x and y.
//!
//! Each named object is a signed distance function (negative inside) meshed by surface nets. Its surface is
//! closed and smooth, and no part is hidden inside the material. In addition, `random-N` names a [random
//! object](random_object) for every number. Their seeds are [separate](crate::random_object::seeds) from all
//! seeds that planners are trained on.

mod bracket;
mod mug;
mod shape;
mod surface;
mod teapot;
mod torus_knot;

use crate::mesh::TriangleMesh;
use crate::random_object::{random_object, seeds};
use glam::DVec3;

/// Returns the names of the objects, except the random ones.
pub fn names() -> impl Iterator<Item = &'static str> {
    OBJECTS.iter().map(|(name, _)| *name)
}

/// Returns the object with this name: one of [`names`], or `random-N` with a whole number below 2^63. `None`
/// if there is no such object.
///
/// ```
/// let mug = nextview_sim::builtin::by_name("mug").unwrap();
/// assert!(mug.triangles().len() > 5000);
/// assert!(nextview_sim::builtin::by_name("cup").is_none());
/// assert!(nextview_sim::builtin::by_name("random-17").is_some());
/// ```
pub fn by_name(name: &str) -> Option<TriangleMesh> {
    let mesh = match name.strip_prefix("random-") {
        Some(number) => random_object(seeds::named(number.parse().ok()?)?),
        None => OBJECTS.iter().find(|(known, _)| *known == name)?.1(),
    };
    Some(stand_on_table(&mesh))
}

type Make = fn() -> TriangleMesh;

const OBJECTS: [(&str, Make); 4] = [
    ("teapot", teapot::make),
    ("mug", mug::make),
    ("bracket", bracket::make),
    ("torus-knot", torus_knot::make),
];

fn stand_on_table(mesh: &TriangleMesh) -> TriangleMesh {
    let (bounds, center) = (mesh.bounds(), mesh.bounds().center());
    mesh.translated(-DVec3::new(center.x, center.y, bounds.min.z)).expect("a small offset keeps a mesh valid")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Every edge has two triangles, which traverse it in opposite directions.
    fn assert_closed(mesh: &TriangleMesh) {
        let mut n_uses = BTreeMap::new();
        for &[a, b, c] in mesh.triangles() {
            for edge in [(a, b), (b, c), (c, a)] {
                *n_uses.entry(edge).or_insert(0) += 1;
            }
        }
        for (&(a, b), &n) in &n_uses {
            assert_eq!((n, n_uses.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
        }
    }

    fn assert_stands(mesh: &TriangleMesh) {
        let bounds = mesh.bounds();
        assert!(bounds.center().truncate().length() < 1e-12 && bounds.min.z.abs() < 1e-12, "{bounds:?}");
    }

    fn volume(mesh: &TriangleMesh) -> f64 {
        let corners = (0..mesh.triangles().len()).map(|i| mesh.corners(i));
        corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn objects_are_closed_and_of_the_stated_size() {
        for name in names() {
            let mesh = by_name(name).unwrap();
            assert_closed(&mesh);
            assert_eq!(mesh.n_degenerate(), 0, "{name}");
            let (bounds, n) = (mesh.bounds(), mesh.triangles().len());
            assert!((0.15..=0.2).contains(&bounds.longest_side()), "{name}: {}", bounds.size());
            assert!((5_000..60_000).contains(&n), "{name}: {n} triangles");
            assert_stands(&mesh);
            let fill = volume(&mesh) / bounds.size().element_product();
            assert!((0.05..0.35).contains(&fill), "{name}: hollow things fill little of their box: {fill}");
        }
    }

    #[test]
    fn every_number_names_a_random_object() {
        for number in [0, 17, i64::MAX as u64] {
            let mesh = by_name(&format!("random-{number}")).unwrap();
            let seed = (1 << 63) + number;
            let (size, expected) = (mesh.bounds().size(), random_object(seed).bounds().size());
            assert!(size.abs_diff_eq(expected, 1e-12), "random-{number}: {size}, expected {expected}");
            assert_stands(&mesh);
        }
        for name in ["random", "random-", "random-x", "random--1", "random-1.5", "random-9223372036854775808"]
        {
            assert!(by_name(name).is_none(), "{name}");
        }
    }

    /// The planner's prior was learned from the objects with the seeds 0 to 199.
    #[test]
    fn no_named_object_is_one_that_was_learned_from() {
        let sizes: Vec<DVec3> = (0..200).map(|seed| random_object(seed).bounds().size()).collect();
        for number in (0..20).chain([199]) {
            let size = by_name(&format!("random-{number}")).unwrap().bounds().size();
            let is_close = |other: &DVec3| size.abs_diff_eq(*other, 1e-6);
            assert!(!sizes.iter().any(is_close), "random-{number} is a training object");
        }
    }
}
