//! The measured surface, only as fine as a page needs.

use crate::scan::scan_copy::ScanCopy;
use nextview::Cancel;
use nextview::geometry::Lattice;
use nextview::map::Occupancy;
use nextview_model::{DistanceField, SurfaceMesh};

/// Size of cells relative to those of the final model: larger ones close the gaps of single frames, and a
/// picture of the whole object shows no smaller ones.
const COARSER: f64 = 1.4;

/// Vertices of a surface per occupied voxel of a map with voxels as large as its cells.
const VERTICES_PER_VOXEL: f64 = 1.6;

/// Extra enlargement of cells when there are too many: the next frame adds more.
const SPARE: f64 = 1.1;

/// The fused frames: the next surface adds one more.
#[derive(Default)]
pub(crate) struct FusedFrames {
    field: Option<DistanceField>,
    n_frames: usize,
}

impl FusedFrames {
    /// The surface with at most `max_vertices` vertices, and the edge of its cells, metres; `None` if there
    /// is no object. Box and poses of the frames must be unchanged.
    ///
    /// The map determines the size of the cells: a second attempt would cost as much time as the first.
    pub fn surface(&mut self, scan: &ScanCopy, max_vertices: usize) -> Option<(SurfaceMesh, f64)> {
        let mut cell = match &self.field {
            Some(field) => field.lattice().voxel_size(),
            None => first_cell(scan, max_vertices)?,
        };
        loop {
            // A cancelled scan has a page, too.
            let cancel = &Cancel::default();
            let mesh = self.fuse(scan, cell)?.surface(cancel).ok()?;
            let excess = mesh.vertices.len() as f64 / max_vertices as f64;
            if excess <= 1.0 {
                return Some((mesh, cell));
            }
            *self = Self::default();
            cell *= SPARE * excess.sqrt();
        }
    }

    /// Adds the frames that are not fused yet.
    fn fuse(&mut self, scan: &ScanCopy, cell: f64) -> Option<&DistanceField> {
        if self.field.is_none() {
            let lattice = Lattice::new(cell).ok()?;
            let block = lattice.block_inside(&scan.place?.0)?;
            self.field = Some(DistanceField::new(lattice, block, 2.0 * cell).ok()?);
        }
        let field = self.field.as_mut()?;
        for frame in scan.model_frames.iter().skip(self.n_frames) {
            let top = scan.table_tops.map(|tops| tops.in_frame(frame));
            field.integrate_above(frame, top, &Cancel::default()).ok()?;
        }
        self.n_frames = scan.model_frames.len();
        Some(field)
    }
}

fn first_cell(scan: &ScanCopy, max_vertices: usize) -> Option<f64> {
    let n_occupied = scan.snapshot.as_ref()?.count(Occupancy::Occupied) as f64;
    let enough = scan.voxel_size * (VERTICES_PER_VOXEL * n_occupied / max_vertices as f64).sqrt();
    Some(enough.max(COARSER * scan.place?.1))
}
