//! Meshing of a signed distance function.

use crate::mesh::TriangleMesh;
use glam::DVec3;
use nextview::geometry::{Aabb, Lattice, VoxelBlock, VoxelKey};
use nextview_model::surface_nets;

/// Voxels per side of a part that is skipped if the surface is far from its middle.
const PART: i32 = 4;

/// The zero level of `distance`, which must lie more than a cell inside `bounds`; sides face outwards.
///
/// Parts thinner than two cells may get holes. Distances may be too large by a fifth.
pub(super) fn surface(bounds: Aabb, cell: f64, distance: impl Fn(DVec3) -> f64) -> TriangleMesh {
    let lattice = Lattice::new(cell).expect("cells are millimetres large");
    let block = lattice.block_inside(&bounds).expect("the box is many cells large");
    let values = sample(&lattice, &block, &distance);
    let mut mesh = surface_nets(&lattice, &block, |i| Some(values[i]));
    mesh.vertices.iter_mut().for_each(|v| *v = onto_surface(*v, cell, &distance));
    TriangleMesh::new(mesh.vertices, mesh.triangles).expect("a body in the box has a surface")
}

/// The distance at every voxel's centre. In parts far from the surface only the sign is right.
fn sample(lattice: &Lattice, block: &VoxelBlock, distance: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let part_of = |key: VoxelKey| key.div_euclid(VoxelKey::splat(PART));
    let coarse = Lattice::new(PART as f64 * lattice.voxel_size()).expect("coarser than a lattice");
    let (first, last) = (part_of(block.min()), part_of(block.max()));
    let parts = VoxelBlock::new(first, (last - first + 1).as_uvec3()).expect("a block has voxels");
    let middles: Vec<f64> = (0..parts.n_voxels()).map(|i| distance(coarse.center(parts.key(i)))).collect();
    let reach = 1.2 * 0.5 * 3.0_f64.sqrt() * coarse.voxel_size();
    let at = |key: VoxelKey| {
        let middle = middles[parts.index(part_of(key)).expect("the parts cover the block")];
        if middle.abs() > reach { middle } else { distance(lattice.center(key)) }
    };
    (0..block.n_voxels()).map(|i| at(block.key(i))).collect()
}

/// Moves a point onto the surface by Newton's method; at most half a cell, so that triangles do not fold
/// over.
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
