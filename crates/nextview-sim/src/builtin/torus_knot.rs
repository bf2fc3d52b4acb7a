use super::surface::surface;
use crate::mesh::TriangleMesh;
use glam::DVec3;
use nextview::geometry::Aabb;
use std::f64::consts::TAU;

const TUBE: f64 = 0.014;

/// A trefoil: a tube that winds twice around the z axis and three times around a ring.
pub(super) fn make() -> TriangleMesh {
    let n = 48;
    let starts: Vec<(f64, DVec3)> =
        (0..n).map(|i| TAU * i as f64 / n as f64).map(|t| (t, course(t).0)).collect();
    let bounds = Aabb { min: DVec3::new(-0.1, -0.1, -0.045), max: DVec3::new(0.1, 0.1, 0.045) };
    surface(bounds, 0.0022, |p| {
        let nearer = |a: &&(f64, DVec3), b: &&(f64, DVec3)| {
            a.1.distance_squared(p).total_cmp(&b.1.distance_squared(p))
        };
        let (start, _) = starts.iter().min_by(nearer).expect("the course has points");
        nearest_on_course(p, *start).distance(p) - TUBE
    })
}

/// The nearest point of the course, by Gauss-Newton steps from a point nearby.
fn nearest_on_course(p: DVec3, start: f64) -> DVec3 {
    let mut turn = start;
    for _ in 0..3 {
        let (position, speed) = course(turn);
        turn += (p - position).dot(speed) / speed.length_squared();
    }
    course(turn).0
}

/// The centre line of the tube after a share of a turn (0 to 2 pi), and its derivative.
fn course(turn: f64) -> (DVec3, DVec3) {
    let ((sin, cos), (sin_winding, cos_winding)) = ((2.0 * turn).sin_cos(), (3.0 * turn).sin_cos());
    let (ring, winding) = (0.054, 0.026);
    let outwards = DVec3::new(cos, sin, 0.0);
    let radius = ring + winding * cos_winding;
    let position = radius * outwards + winding * sin_winding * DVec3::Z;
    let speed = 2.0 * radius * DVec3::new(-sin, cos, 0.0)
        + 3.0 * winding * (cos_winding * DVec3::Z - sin_winding * outwards);
    (position, speed)
}
