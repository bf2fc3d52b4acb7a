//! Signed distances to simple bodies, and ways to join them: metres, negative inside. Outside a body the
//! value may be smaller than the true distance, but never much larger (formulas: Quilez, "distance
//! functions").

use glam::{DVec2, DVec3};

/// A box around the origin with rounded edges; `half` includes the rounding.
pub(super) fn rounded_box(p: DVec3, half: DVec3, rounding: f64) -> f64 {
    let beyond = p.abs() - (half - rounding);
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0) - rounding
}

/// An infinite cylinder, from the offset to its axis.
pub(super) fn cylinder(offset: DVec2, radius: f64) -> f64 {
    offset.length() - radius
}

/// A tube along a line of points, each with its radius; the ends are round.
pub(super) fn tube(p: DVec3, points: &[(DVec3, f64)]) -> f64 {
    let segments = points.windows(2).map(|ends| {
        let ((a, radius_a), (b, radius_b)) = (ends[0], ends[1]);
        let along = b - a;
        let share = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        p.distance(a + share * along) - (radius_a + share * (radius_b - radius_a))
    });
    segments.fold(f64::INFINITY, f64::min)
}

/// Distance to a line of points in the plane, positive on both sides.
pub(super) fn line(p: DVec2, points: &[DVec2]) -> f64 {
    let flat: f64 = points
        .windows(2)
        .map(|ends| {
            let along = ends[1] - ends[0];
            let share = ((p - ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            p.distance_squared(ends[0] + share * along)
        })
        .fold(f64::INFINITY, f64::min);
    flat.sqrt()
}

/// `n + 1` points of a cubic Bezier curve, with a radius that changes evenly from one end to the other.
pub(super) fn bezier(control: [DVec3; 4], radius: [f64; 2], n: usize) -> Vec<(DVec3, f64)> {
    (0..=n)
        .map(|i| {
            let t = i as f64 / n as f64;
            let [a, b, c, d] = control;
            let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
            (ab.lerp(bc, t).lerp(bc.lerp(cd, t), t), radius[0] + t * (radius[1] - radius[0]))
        })
        .collect()
}

/// Distance from the z axis, and height: where a point lies in the profile of a turned body.
pub(super) fn turned(p: DVec3) -> DVec2 {
    DVec2::new(p.truncate().length(), p.z)
}

/// Both bodies, with the corner between them filled over about `width`.
pub(super) fn join(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - 0.25 * width * overlap * overlap
}

/// The first body without the second, with the edge between them rounded over about `width`.
pub(super) fn cut(a: f64, b: f64, width: f64) -> f64 {
    -join(-a, b, width)
}
