//! The measured surface, no finer than a page needs it.

use nextview::geometry::Lattice;
use nextview::map::Occupancy;
use nextview::surface::{DistanceField, SurfaceMesh};
use nextview::{Cancel, Error};
use nextview_scan::FinishedScan;

/// Cells are this much larger than those of the final model: what single frames leave open closes, and a
/// picture of the whole object shows no smaller ones.
const COARSER: f64 = 1.4;

/// Vertices of a surface over the occupied voxels of a map with voxels as large as its cells.
const VERTICES_PER_VOXEL: f64 = 1.6;

/// The surface with at most so many vertices, and the edge of its cells, metres; none if there is no object.
///
/// The map says how large the cells must be: a second attempt would cost as much time as the first.
pub(super) fn of_scan(
    scan: &FinishedScan<'_>,
    max_vertices: usize,
    cancel: &Cancel,
) -> Option<(SurfaceMesh, f64)> {
    let voxel_size = scan.session.map().lattice().voxel_size();
    let n_occupied = scan.session.snapshot()?.count(Occupancy::Occupied) as f64;
    let enough = voxel_size * (VERTICES_PER_VOXEL * n_occupied / max_vertices as f64).sqrt();
    let mut cell = enough.max(COARSER * scan.detail(scan.bounds()?));
    loop {
        let mesh = with_cells(scan, cell, cancel).ok()?;
        let excess = mesh.vertices.len() as f64 / max_vertices as f64;
        if excess <= 1.0 {
            return Some((mesh, cell));
        }
        cell *= 1.05 * excess.sqrt();
    }
}

fn with_cells(scan: &FinishedScan<'_>, cell: f64, cancel: &Cancel) -> Result<SurfaceMesh, Error> {
    let lattice = Lattice::new(cell)?;
    let block = scan.bounds().and_then(|bounds| lattice.block_inside(&bounds));
    let Some(block) = block else { return Ok(SurfaceMesh::default()) };
    let mut field = DistanceField::new(lattice, block, 2.0 * cell)?;
    scan.session.frames().iter().try_for_each(|frame| field.integrate(frame, cancel))?;
    Ok(field.surface(cancel)?)
}
