//! A z-buffer rasteriser that loses no hit: a sample point is covered by a triangle if it lies on the same side of
//! its three edges or on one of them (Pineda 1988). The side is computed so that the two triangles at an edge
//! always get opposite answers, and a point on a corner gets an exact zero; so no sample falls between
//! neighbours, whatever is rounded.

use super::draw_list::DrawList;
use super::samples::{CellBox, SampleGrid};
use glam::{DVec2, DVec3};
use nextview::geometry::Pose;

/// Surfaces nearer than this are not seen, metres.
pub(super) const MIN_DEPTH: f64 = 1e-3;

/// A vertex seen by the camera.
#[derive(Clone, Copy)]
struct Projected {
    ideal: DVec2,
    /// 1 / depth; 0 for a vertex nearer than [`MIN_DEPTH`] or behind the camera.
    inverse_depth: f64,
}

/// 1 / depth of the nearest surface at every sample, 0 where there is none.
pub(super) fn nearest_surfaces(grid: &SampleGrid, list: &DrawList, world_from_camera: &Pose) -> Vec<f64> {
    let camera_from_world = world_from_camera.inverse();
    let (rotation, translation) = (camera_from_world.rotation_matrix(), camera_from_world.translation());
    let to_camera = |point: DVec3| rotation * point + translation;
    let (boxes, vertices): (Vec<CellBox>, Vec<Projected>) =
        list.vertices.iter().map(|&v| project(grid, to_camera(v))).unzip();

    let mut nearest = vec![0.0; grid.pixels().len()];
    for triangle in &list.triangles {
        let corner = triangle.map(|i| i as usize);
        let cells = CellBox::around(boxes[corner[0]], boxes[corner[1]], boxes[corner[2]]);
        if cells.is_empty() {
            continue;
        }
        let seen = corner.map(|i| vertices[i]);
        if seen.iter().all(|v| v.inverse_depth > 0.0) {
            draw(grid, &mut nearest, cells, &seen);
        } else {
            draw_clipped(grid, &mut nearest, corner.map(|i| to_camera(list.vertices[i])));
        }
    }
    nearest
}

/// A vertex, and the cells that may hold a sample at it. The cells are kept apart because they alone decide about
/// most triangles of a fine mesh: those that fall between the samples.
#[inline]
fn project(grid: &SampleGrid, point: DVec3) -> (CellBox, Projected) {
    if point.z < MIN_DEPTH {
        return (grid.all(), Projected { ideal: DVec2::ZERO, inverse_depth: 0.0 });
    }
    let inverse_depth = 1.0 / point.z;
    let ideal = point.truncate() * inverse_depth;
    (grid.box_of(ideal), Projected { ideal, inverse_depth })
}

/// Draws a triangle of which every corner lies in front of the camera.
#[inline]
fn draw(grid: &SampleGrid, nearest: &mut [f64], cells: CellBox, [a, b, c]: &[Projected; 3]) {
    let (x, y) = grid.coordinates();
    for row in cells.first[1]..cells.end[1] {
        let range = grid.in_row(cells, row);
        let samples = x[range.clone()].iter().zip(&y[range.clone()]);
        for ((&x, &y), nearest) in samples.zip(&mut nearest[range]) {
            let sample = DVec2::new(x, y);
            let (to_a, to_b, to_c) = (a.ideal - sample, b.ideal - sample, c.ideal - sample);
            let (at_a, at_b, at_c) = (to_b.perp_dot(to_c), to_c.perp_dot(to_a), to_a.perp_dot(to_b));
            let is_left = (at_a >= 0.0) & (at_b >= 0.0) & (at_c >= 0.0);
            let is_right = (at_a <= 0.0) & (at_b <= 0.0) & (at_c <= 0.0);
            let sum = at_a + at_b + at_c;
            // A triangle seen edge-on has no inside: its sum is 0. One branch, because none can be predicted.
            if (is_left | is_right) & (sum != 0.0) {
                let weighted = at_a * a.inverse_depth + at_b * b.inverse_depth + at_c * c.inverse_depth;
                *nearest = nearest.max(weighted / sum);
            }
        }
    }
}

/// Draws the part of a triangle that lies beyond the smallest depth.
fn draw_clipped(grid: &SampleGrid, nearest: &mut [f64], corners: [DVec3; 3]) {
    let (polygon, n) = clip(corners);
    let seen = polygon.map(|corner| project(grid, corner));
    for i in 2..n {
        let [first, second, third] = [seen[0], seen[i - 1], seen[i]];
        let cells = CellBox::around(first.0, second.0, third.0);
        draw(grid, nearest, cells, &[first.1, second.1, third.1]);
    }
}

/// The part of a triangle beyond the smallest depth: a polygon of 0, 3 or 4 corners.
fn clip(corners: [DVec3; 3]) -> ([DVec3; 4], usize) {
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
        // Always from the visible end, so that both triangles at the edge are cut at the same point.
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
