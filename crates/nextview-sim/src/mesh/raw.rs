use super::{Appearance, Face, Material, TriangleMesh, limit};
use crate::SimError;
use glam::DVec3;

/// A parser's output: vertices in the file's unit and triangles, not yet checked.
#[derive(Debug, Default)]
pub(super) struct RawMesh {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Colours of the first vertices; the others are white. Empty if no vertex has a colour.
    pub colors: Vec<[u8; 3]>,
    /// Materials of the first triangles; the others have none.
    pub faces: Vec<Face>,
    /// The materials named by faces.
    pub materials: Vec<Material>,
    /// The first error in the colours, which removes all colours.
    pub color_fault: Option<SimError>,
    /// Faces with fewer than three corners.
    pub n_too_small: usize,
}

impl RawMesh {
    /// Cuts a polygon into triangles that share its first corner.
    pub fn push_polygon(&mut self, corners: &[u32]) {
        match corners {
            [first, rest @ ..] if rest.len() >= 2 => {
                self.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ => self.n_too_small += 1,
        }
    }

    /// Sets the colours of the vertices from `first` on; earlier ones stay unchanged.
    pub fn push_colors(&mut self, first: usize, colors: impl IntoIterator<Item = [u8; 3]>) {
        self.colors.resize(first, [255; 3]);
        self.colors.extend(colors);
    }

    /// The result of a step of reading colours. An error does not reject the shape, and is stored.
    pub fn colors_or_fault<T>(&mut self, read: Result<T, SimError>) -> Option<T> {
        read.map_err(|fault| _ = self.color_fault.get_or_insert(fault)).ok()
    }

    /// The colours; `None` if neither vertices nor triangles have any, or if some are wrong.
    fn take_appearance(&mut self) -> Option<Appearance> {
        if self.color_fault.is_some() {
            return None;
        }
        if self.colors.is_empty() && self.faces.iter().all(|face| face.material.is_none()) {
            return None;
        }
        let mut vertex_colors = std::mem::take(&mut self.colors);
        if !vertex_colors.is_empty() {
            vertex_colors.resize(self.vertices.len(), [255; 3]);
        }
        let mut faces = std::mem::take(&mut self.faces);
        if !faces.is_empty() {
            faces.resize(self.triangles.len(), Face::default());
        }
        Some(Appearance { vertex_colors, faces, materials: std::mem::take(&mut self.materials) })
    }

    /// Returns the checked mesh of a file of this size, the number of faces dropped for lack of area, and the
    /// reason why it has no colours although the file has some.
    pub fn check(mut self, n_bytes: u64) -> Result<(TriangleMesh, usize, Option<SimError>), SimError> {
        limit::check(self.vertices.len(), self.triangles.len(), n_bytes)?;
        let mesh = match self.take_appearance() {
            Some(appearance) => TriangleMesh::colored(self.vertices, self.triangles, appearance),
            None => TriangleMesh::new(self.vertices, self.triangles),
        };
        let mesh = mesh.map_err(|error| match error {
            SimError::NoFaces { n_degenerate } => {
                SimError::NoFaces { n_degenerate: n_degenerate + self.n_too_small }
            }
            other => other,
        })?;
        let n_dropped = mesh.n_degenerate() + self.n_too_small;
        Ok((mesh, n_dropped, self.color_fault))
    }
}
