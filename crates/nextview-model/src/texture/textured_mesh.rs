use glam::{DVec2, DVec3};
use nextview::sensor::ColorImage;

/// A surface with an image on it.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturedMesh {
    /// The vertices, metres.
    pub vertices: Vec<DVec3>,
    /// Three indices into the vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates: (0, 0) is the lower left corner and (1, 1) the upper right, as in OBJ.
    pub texture_points: Vec<DVec2>,
    /// Texture coordinates of the corners of each triangle: three indices into the texture points.
    pub texture_triangles: Vec<[u32; 3]>,
    /// The texture image.
    pub texture: ColorImage,
}
