use super::vertex::ShownVertex;
use super::{FusedFrames, expected, looks};
use crate::scan::scan_copy::ScanCopy;
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::surface::SurfaceMesh;
use nextview_scan::FinishedScan;

/// The surface that a scan has measured, the surface that is expected beside it, and what each view candidate
/// is expected to show.
///
/// [`ShownModel::default`] is nothing: the page then shows points alone.
#[derive(Clone, Debug, Default)]
pub struct ShownModel {
    pub(crate) vertices: Vec<ShownVertex>,
    /// Three indices into the vertices each, counter-clockwise as seen from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Around the unseen voxels that probably hold surface.
    pub(crate) expected: SurfaceMesh,
    /// By candidate, the voxels of new surface that it is expected to show; empty if that is not known.
    pub(crate) gains: Vec<f64>,
    /// The normal of the table; none where none is known.
    pub(crate) up: Option<DVec3>,
    /// The box around the object, metres; none where none is known.
    pub(crate) bounds: Option<Aabb>,
}

impl ShownModel {
    /// The model of a scan, finished or under way, with at most so many vertices. It takes about as long as
    /// the final mesh.
    ///
    /// Parts that cannot be made are left out: before an object was found, all of them.
    pub fn of_scan(scan: &FinishedScan<'_>, max_vertices: usize) -> Self {
        Self::of_copy(&ScanCopy::of(scan), &mut FusedFrames::default(), max_vertices)
    }

    /// The same with the frames that were fused before.
    pub(crate) fn of_copy(scan: &ScanCopy, fused: &mut FusedFrames, max_vertices: usize) -> Self {
        let (mesh, cell) = fused.surface(scan, max_vertices).unwrap_or_default();
        let (expected, gains) = expected::of_scan(scan).unwrap_or_default();
        let vertices = looks::vertices(scan, &mesh, cell);
        let up = scan.table.map(|table| table.normal());
        let bounds = scan.place.map(|(bounds, _)| bounds);
        Self { vertices, triangles: mesh.triangles, expected, gains, up, bounds }
    }
}
