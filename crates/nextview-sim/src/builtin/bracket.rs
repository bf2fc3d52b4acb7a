use super::shape::{cut, cylinder, join, rounded_box};
use super::surface::surface;
use crate::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use nextview::geometry::Aabb;

const LENGTH: f64 = 0.16;
const THICKNESS: f64 = 0.009;

/// A steel angle: base plate and upright plate, both with round holes, stiffened by two ribs.
pub(super) fn make() -> TriangleMesh {
    let bounds = Aabb { min: DVec3::new(-0.085, -0.005, -0.005), max: DVec3::new(0.085, 0.09, 0.1) };
    surface(bounds, 0.002, |p| {
        let angle = cut(angle(p), 0.5 * LENGTH - p.x.abs(), 0.003);
        cut(join(angle, rib(p), 0.004), holes(p), 0.002)
    })
}

/// The two plates without their ends: one profile along x.
fn angle(p: DVec3) -> f64 {
    let plate = |across: f64, along: f64, width: f64| {
        let half = DVec3::new(LENGTH, 0.5 * THICKNESS, 0.5 * width);
        rounded_box(DVec3::new(p.x, across, along) - half.with_x(0.0), half, 0.0015)
    };
    let (base, upright) = (plate(p.z, p.y, 0.085), plate(p.y, p.z, 0.095));
    // Only the inner corner has a fillet.
    let is_inner = p.y.min(p.z) > 0.5 * THICKNESS;
    if is_inner { join(base, upright, 0.006) } else { base.min(upright) }
}

/// Two triangles that stand across both plates, from their middles on.
fn rib(p: DVec3) -> f64 {
    let (low, size) = (0.5 * THICKNESS, DVec2::new(0.064, 0.074));
    let half = DVec3::new(0.005, 0.5 * size.x, 0.5 * size.y);
    let block =
        rounded_box(DVec3::new(p.x.abs() - 0.035, p.y - low, p.z - low) - half.with_x(0.0), half, 0.003);
    let slope = DVec2::new(size.y, size.x).normalize();
    let beyond_slope = slope.dot(DVec2::new(p.y - low - size.x, p.z - low));
    cut(block, -beyond_slope, 0.006)
}

/// Two holes in the middle of each plate, four small ones beyond the ribs.
fn holes(p: DVec3) -> f64 {
    let side = p.x.abs();
    let in_base = |x: f64, y: f64, radius: f64| cylinder(DVec2::new(side - x, p.y - y), radius);
    let in_upright = |x: f64, z: f64, radius: f64| cylinder(DVec2::new(side - x, p.z - z), radius);
    let base = in_base(0.06, 0.03, 0.006).min(in_base(0.06, 0.065, 0.006)).min(in_base(0.0, 0.05, 0.012));
    let upright =
        in_upright(0.06, 0.03, 0.006).min(in_upright(0.06, 0.075, 0.006)).min(in_upright(0.0, 0.06, 0.016));
    // Each row of holes goes through its own plate only.
    base.max(p.z - 0.02).min(upright.max(p.y - 0.02))
}
