use super::vertex::ShownVertex;
use super::{expected, looks, surface};
use nextview::Cancel;
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
    /// By candidate, the voxels of surface that it is expected to show anew; empty if that is not known.
    pub(crate) gains: Vec<f64>,
}

impl ShownModel {
    /// The model of a scan, finished or under way, with at most so many vertices. It takes about as long as
    /// the final mesh.
    ///
    /// Parts that cannot be made are left out: before an object was found, all of them.
    pub fn of_scan(scan: &FinishedScan<'_>, max_vertices: usize) -> Self {
        // A page is wanted of a scan that was cancelled, too.
        let cancel = &Cancel::default();
        let (mesh, cell) = surface::of_scan(scan, max_vertices, cancel).unwrap_or_default();
        let (expected, gains) = expected::of_session(&scan.session, cancel).unwrap_or_default();
        Self { vertices: looks::vertices(scan, &mesh, cell), triangles: mesh.triangles, expected, gains }
    }
}
