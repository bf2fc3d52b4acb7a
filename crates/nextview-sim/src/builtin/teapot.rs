use super::shape::{bezier, cut, cylinder, join, tube, turned};
use super::surface::surface;
use crate::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use nextview::geometry::Aabb;

const WALL: f64 = 0.005;
/// Half axes of the belly, and the height of its middle; it is cut off at the foot.
const BELLY: DVec2 = DVec2::new(0.058, 0.05);
const MIDDLE: f64 = 0.042;
/// Radius of the opening, and height of its rim.
const OPENING: f64 = 0.03;
const RIM: f64 = 0.086;

/// A teapot without its lid: hollow, with an open spout at +x and a handle at -x.
pub(super) fn make() -> TriangleMesh {
    let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let course = [at(0.036, 0.028), at(0.088, 0.026), at(0.064, 0.076), at(0.097, 0.084)];
    let spout = bezier(course, [0.017, 0.0095], 20);
    let mut bore = bezier(course, [0.0125, 0.005], 20);
    bore.push((at(0.12, 0.0895), 0.006));
    let handle =
        bezier([at(-0.046, 0.072), at(-0.104, 0.092), at(-0.1, 0.008), at(-0.05, 0.026)], [0.0062; 2], 20);
    let bounds = Aabb { min: DVec3::new(-0.1, -0.065, -0.005), max: DVec3::new(0.12, 0.065, 0.1) };
    surface(bounds, 0.0021, |p| {
        let in_profile = turned(p);
        let belly = belly(in_profile);
        let collar = (in_profile - DVec2::new(OPENING + 0.5 * WALL, RIM)).length() - 0.75 * WALL;
        let with_parts = join(join(belly, tube(p, &spout), 0.008), tube(p, &handle), 0.008);
        let outside = join(with_parts, collar, 0.005);
        let opening = cylinder(p.truncate(), OPENING).max(MIDDLE - p.z);
        let inside = (belly + WALL).min(opening).min(tube(p, &bore));
        cut(outside, inside, 0.003)
    })
}

/// An ellipsoid cut off at z = 0, by the first-order distance to it.
fn belly(in_profile: DVec2) -> f64 {
    let relative = in_profile - DVec2::new(0.0, MIDDLE);
    let scaled = (relative / BELLY).length();
    let slope = (relative / (BELLY * BELLY)).length();
    let ellipsoid = if scaled > 0.3 { scaled * (scaled - 1.0) / slope } else { -BELLY.y * (1.0 - scaled) };
    cut(ellipsoid, in_profile.y, 0.004)
}
