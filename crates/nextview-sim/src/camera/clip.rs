use super::projection::MIN_DEPTH;
use glam::DVec3;

/// The part of a triangle, in camera coordinates, beyond the smallest depth: a polygon of 0, 3 or 4 corners.
pub(super) fn clip(corners: [DVec3; 3]) -> ([DVec3; 4], usize) {
    let (mut polygon, mut n) = ([DVec3::ZERO; 4], 0);
    let mut push = |corner| {
        polygon[n] = corner;
        n += 1;
    };
    for i in 0..3 {
        let (here, next) = (corners[i], corners[(i + 1) % 3]);
        if here.z >= MIN_DEPTH {
            push(here);
        }
        // Always from the visible end: both triangles at the edge are cut at the same point.
        match (here.z >= MIN_DEPTH, next.z >= MIN_DEPTH) {
            (true, false) => push(cut(here, next)),
            (false, true) => push(cut(next, here)),
            _ => {}
        }
    }
    (polygon, n)
}

/// Where an edge crosses the smallest depth.
fn cut(visible: DVec3, hidden: DVec3) -> DVec3 {
    let share = (visible.z - MIN_DEPTH) / (visible.z - hidden.z);
    let crossing = visible + share * (hidden - visible);
    DVec3::new(crossing.x, crossing.y, MIN_DEPTH)
}
