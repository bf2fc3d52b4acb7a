//! Meshing of a signed distance function by surface nets (Gibson 1998): one vertex in each cell of a grid that the
//! surface crosses, one quadrilateral around each grid edge that it crosses.

use crate::mesh::TriangleMesh;
use glam::{DVec3, IVec3, UVec3};
use nextview::geometry::{Aabb, VoxelBlock};

/// Nodes per side of a block that is skipped if the surface is far from its middle.
const BLOCK: u32 = 4;

/// The surface where `distance` is zero, which must lie inside `bounds`; sides show outwards.
///
/// Parts thinner than two cells may get holes. Distances may be too large by a fifth.
pub(super) fn surface(bounds: Aabb, cell: f64, distance: impl Fn(DVec3) -> f64) -> TriangleMesh {
    let dims = (bounds.size() / cell).ceil().as_uvec3() + 1;
    let grid = VoxelBlock::new(IVec3::ZERO, dims).expect("at least one node on each axis");
    let values = sample(&grid, cell, |node| distance(bounds.min + cell * node));

    let mut vertices = Vec::new();
    let mut vertex_of = vec![None; grid.n_voxels()];
    for (i, vertex) in vertex_of.iter_mut().enumerate() {
        if let Some(middle) = middle_of_crossings(&grid, &values, i) {
            *vertex = Some(vertices.len() as u32);
            vertices.push(onto_surface(bounds.min + cell * middle, cell, &distance));
        }
    }
    let quads = (0..grid.n_voxels()).flat_map(|i| quads_around(&grid, &values, &vertex_of, i));
    let triangles = quads.flat_map(|quad| split(quad, &vertices, &distance)).collect();
    TriangleMesh::new(vertices, triangles).expect("a body in the box has a surface")
}

/// The distance at every node, from `distance` at a position in cells. In blocks far from the surface only its sign
/// is right.
fn sample(grid: &VoxelBlock, cell: f64, distance: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let mut values = vec![0.0; grid.n_voxels()];
    let n_blocks = grid.dims().map(|n| n.div_ceil(BLOCK));
    let reach = 1.2 * 0.5 * 3.0_f64.sqrt() * BLOCK as f64 * cell;
    for block in nodes(n_blocks) {
        let first = BLOCK * block;
        let middle = distance(first.as_dvec3() + 0.5 * (BLOCK - 1) as f64);
        for local in nodes((grid.dims() - first).min(UVec3::splat(BLOCK))) {
            let node = first + local;
            let index = grid.index(node.as_ivec3()).expect("the block is cut at the grid's border");
            values[index] = if middle.abs() > reach { middle } else { distance(node.as_dvec3()) };
        }
    }
    values
}

fn nodes(dims: UVec3) -> impl Iterator<Item = UVec3> {
    (0..dims.z)
        .flat_map(move |z| (0..dims.y).flat_map(move |y| (0..dims.x).map(move |x| UVec3::new(x, y, z))))
}

/// The mean of the points where the surface crosses the edges of the cell with lowest node `i`, in cells; none if it
/// crosses none.
fn middle_of_crossings(grid: &VoxelBlock, values: &[f64], i: usize) -> Option<DVec3> {
    let node = grid.key(i);
    let corner = |c: i32| IVec3::new(c & 1, c >> 1 & 1, c >> 2 & 1);
    let (mut sum, mut n) = (DVec3::ZERO, 0);
    grid.index(node + 1)?;
    for c in 0..8 {
        for axis in 0..3 {
            if c >> axis & 1 == 1 {
                continue;
            }
            let (from, to) = (node + corner(c), node + corner(c | 1 << axis));
            let (a, b) = (values[grid.index(from)?], values[grid.index(to)?]);
            if (a < 0.0) != (b < 0.0) {
                sum += from.as_dvec3().lerp(to.as_dvec3(), a / (a - b));
                n += 1;
            }
        }
    }
    (n > 0).then(|| sum / n as f64)
}

/// Moves a point onto the surface by Newton's method; at most half a cell, so that triangles do not fold over.
fn onto_surface(start: DVec3, cell: f64, distance: &impl Fn(DVec3) -> f64) -> DVec3 {
    let mut p = start;
    for _ in 0..2 {
        let (value, h) = (distance(p), 1e-3 * cell);
        let slope = |axis: DVec3| (distance(p + h * axis) - value) / h;
        let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        p -= value * gradient / gradient.length_squared().max(0.25);
    }
    start + (p - start).clamp_length_max(0.5 * cell)
}

/// The quadrilaterals around those of the three grid edges from node `i` on that cross the surface.
fn quads_around(
    grid: &VoxelBlock,
    values: &[f64],
    vertex_of: &[Option<u32>],
    i: usize,
) -> impl Iterator<Item = [u32; 4]> {
    let (node, strides) = (grid.key(i), grid.strides());
    (0..3).filter_map(move |axis| {
        let end = grid.index(node + IVec3::AXES[axis])?;
        if (values[i] < 0.0) == (values[end] < 0.0) {
            return None;
        }
        let (u, v) = (strides[(axis + 1) % 3], strides[(axis + 2) % 3]);
        let cells = [i, i.checked_sub(u)?, i.checked_sub(u + v)?, i.checked_sub(v)?];
        let [a, b, c, d] = cells.map(|cell| vertex_of[cell]);
        Some(if values[i] < 0.0 { [a?, b?, c?, d?] } else { [d?, c?, b?, a?] })
    })
}

/// Cuts a quadrilateral along the diagonal that lies nearer to the surface.
fn split([a, b, c, d]: [u32; 4], vertices: &[DVec3], distance: &impl Fn(DVec3) -> f64) -> [[u32; 3]; 2] {
    let gap = |i: u32, j: u32| distance(vertices[i as usize].midpoint(vertices[j as usize])).abs();
    if gap(a, c) <= gap(b, d) { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_has_the_area_of_a_ball_and_shows_outwards() {
        let mesh = surface(Aabb::cube(DVec3::ZERO, 0.12), 0.005, |p| p.length() - 0.1);
        let expected = 4.0 * std::f64::consts::PI * 0.01;
        assert!((mesh.area() / expected - 1.0).abs() < 2e-3, "{} instead of {expected}", mesh.area());
        assert!(mesh.vertices().iter().all(|v| (v.length() - 0.1).abs() < 1e-6));
        for i in 0..mesh.triangles().len() {
            let [a, b, c] = mesh.corners(i);
            assert!((b - a).cross(c - a).dot(a) > 0.0);
        }
    }
}
