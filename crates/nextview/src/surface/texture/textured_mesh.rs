use crate::sensor::ColorImage;
use glam::{DVec2, DVec3};

/// A surface with an image on it.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturedMesh {
    /// The vertices, metres.
    pub vertices: Vec<DVec3>,
    /// Three indices into the vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Points of the texture: (0, 0) is its lower left corner and (1, 1) its upper right, as in OBJ.
    pub texture_points: Vec<DVec2>,
    /// Where the corners of each triangle are: three indices into the texture points each.
    pub texture_triangles: Vec<[u32; 3]>,
    /// The image.
    pub texture: ColorImage,
}
