use super::vertex::ShownVertex;
use super::{FusedFrames, expected, looks};
use crate::scan::scan_copy::ScanCopy;
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview_model::SurfaceMesh;
use nextview_scan::ScanState;

/// The measured surface of a scan, the expected surface in addition, and the expected gain of each view
/// candidate.
///
/// [`ShownModel::default`] is empty: the page then shows points alone.
#[derive(Clone, Debug, Default)]
pub struct ShownModel {
    pub(crate) vertices: Vec<ShownVertex>,
    /// Three vertex indices each, counter-clockwise seen from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Surface around the unseen voxels that probably hold surface.
    pub(crate) expected: SurfaceMesh,
    /// Expected number of new surface voxels by candidate; empty if not known.
    pub(crate) gains: Vec<f64>,
    /// The normal of the table; `None` if not known.
    pub(crate) up: Option<DVec3>,
    /// The box around the object, metres; `None` if not known.
    pub(crate) bounds: Option<Aabb>,
}

impl ShownModel {
    /// Creates the model of a scan, finished or in progress, with at most `max_vertices` vertices. It takes
    /// about as long as the final mesh.
    ///
    /// Parts that cannot be made are left out: all of them, before an object was found.
    pub fn of_scan(scan: &ScanState<'_>, max_vertices: usize) -> Self {
        Self::of_copy(&ScanCopy::of(scan), &mut FusedFrames::default(), max_vertices)
    }

    /// Creates the model with the frames fused earlier.
    pub(crate) fn of_copy(scan: &ScanCopy, fused: &mut FusedFrames, max_vertices: usize) -> Self {
        let (mesh, cell) = fused.surface(scan, max_vertices).unwrap_or_default();
        let (expected, gains) = expected::of_scan(scan).unwrap_or_default();
        let vertices = looks::vertices(scan, &mesh, cell);
        let up = scan.table.map(|table| table.normal());
        let bounds = scan.place.map(|(bounds, _)| bounds);
        Self { vertices, triangles: mesh.triangles, expected, gains, up, bounds }
    }
}
