//! The measured surface, no finer than a page needs it.

use nextview::geometry::Lattice;
use nextview::surface::{DistanceField, SurfaceMesh};
use nextview::{Cancel, Error};
use nextview_scan::FinishedScan;

/// Cells are this much larger than those of the final model: what single frames leave open closes, and a
/// picture of the whole object shows no smaller ones.
const COARSER: f64 = 1.8;

/// Vertices of a surface over the squared number of cells along its box, for an object that fills it.
const VERTICES_PER_CELL: f64 = 2.5;

/// The surface with at most so many vertices, and the edge of its cells, metres; none if there is no object.
pub(super) fn of_scan(
    scan: &FinishedScan<'_>,
    max_vertices: usize,
    cancel: &Cancel,
) -> Option<(SurfaceMesh, f64)> {
    let bounds = scan.bounds()?;
    let enough = bounds.longest_side() / (max_vertices as f64 / VERTICES_PER_CELL).sqrt();
    let mut cell = (COARSER * scan.detail(bounds)).max(enough);
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
