use super::{TriangleMesh, limit};
use crate::SimError;
use glam::DVec3;

/// The output of a parser: vertices in the file's unit and triangles, not checked yet.
#[derive(Debug, Default)]
pub(super) struct RawMesh {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
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

    /// The checked mesh of a file of this size, and the number of faces left out because they have no area.
    pub fn check(self, n_bytes: u64) -> Result<(TriangleMesh, usize), SimError> {
        limit::check(self.vertices.len(), self.triangles.len(), n_bytes)?;
        let mesh = TriangleMesh::new(self.vertices, self.triangles).map_err(|error| match error {
            SimError::NoFaces { n_degenerate } => {
                SimError::NoFaces { n_degenerate: n_degenerate + self.n_too_small }
            }
            other => other,
        })?;
        let n_dropped = mesh.n_degenerate() + self.n_too_small;
        Ok((mesh, n_dropped))
    }
}
