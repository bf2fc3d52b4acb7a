use super::shape::{bezier, join, line, tube, turned};
use super::surface::surface;
use crate::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use nextview::geometry::Aabb;

const HEIGHT: f64 = 0.125;
/// Radius of the middle of the wall.
const RADIUS: f64 = 0.05;
const WALL: f64 = 0.006;

/// A mug with a round rim and a handle at +x.
pub(super) fn make() -> TriangleMesh {
    let profile = profile();
    let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let handle =
        bezier([at(0.048, 0.1), at(0.118, 0.118), at(0.112, 0.018), at(0.048, 0.034)], [0.0065; 2], 32);
    let bounds = Aabb { min: DVec3::new(-0.06, -0.06, -0.01), max: DVec3::new(0.12, 0.06, 0.14) };
    surface(bounds, 0.0023, |p| {
        let in_profile = turned(p);
        let shell = line(in_profile, &profile) - 0.5 * WALL;
        // The handle ends in the middle of the wall and leaves no trace on its inner side.
        if in_profile.x > RADIUS { join(shell, tube(p, &handle), 0.008) } else { shell }
    })
}

/// The centre line of bottom and wall, from the axis to the rim, with a rounded corner.
fn profile() -> Vec<DVec2> {
    let corner = 0.014;
    let arc = (0..=12).map(|i| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * i as f64 / 12.0).sin_cos();
        DVec2::new(RADIUS - corner + corner * sin, 0.5 * WALL + corner - corner * cos)
    });
    let axis = DVec2::new(0.0, 0.5 * WALL);
    let rim = DVec2::new(RADIUS, HEIGHT - 0.5 * WALL);
    std::iter::once(axis).chain(arc).chain([rim]).collect()
}
