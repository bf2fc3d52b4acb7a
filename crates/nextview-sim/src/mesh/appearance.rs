use super::srgb;
use crate::SimError;
use nextview::sensor::ColorImage;

/// The colour of a mesh: at each point the product, in linear light, of the interpolated vertex colours, the
/// material, and the material's image there. Anything a list omits is white.
///
/// ```
/// use glam::DVec3;
/// use nextview_sim::mesh::{Appearance, TriangleMesh};
///
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let red = Appearance { vertex_colors: vec![[255, 0, 0]; 3], ..Appearance::default() };
/// let mesh = TriangleMesh::colored(corners, vec![[0, 1, 2]], red).unwrap();
/// assert_eq!(mesh.color(0, [0.2, 0.3, 0.5]), Some([255, 0, 0]));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Red, green and blue of each vertex (sRGB); empty if vertices have no colours.
    pub vertex_colors: Vec<[u8; 3]>,
    /// Material and texture coordinates of each triangle; empty if there are no materials.
    pub faces: Vec<Face>,
    /// The materials that faces name by their index.
    pub materials: Vec<Material>,
}

/// The material of a triangle, and its corners' coordinates in that material's image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Face {
    /// Index of the material; `None` is white.
    pub material: Option<u32>,
    /// Texture coordinates of the corners: (0, 0) is the lower left corner of the image and (1, 1) the upper
    /// right; the image repeats beyond.
    pub texture: [[f32; 2]; 3],
}

/// The colour of a part of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Reflectance in red, green and blue, 0 to 1 (linear).
    pub reflectance: [f32; 3],
    /// The image of the material; `None` is white.
    pub image: Option<ColorImage>,
}

impl Appearance {
    /// Fails unless the lists fit a mesh with these numbers of vertices and triangles.
    pub(super) fn check(&self, n_vertices: usize, n_triangles: usize) -> Result<(), SimError> {
        let fits = |length: usize, n: usize| length == 0 || length == n;
        if !fits(self.vertex_colors.len(), n_vertices) {
            let value = format!("{} colours of {n_vertices} vertices", self.vertex_colors.len());
            return Err(SimError::parameter("vertex_colors", value, "one for each vertex, or none"));
        }
        if !fits(self.faces.len(), n_triangles) {
            let value = format!("{} faces of {n_triangles} triangles", self.faces.len());
            return Err(SimError::parameter("faces", value, "one for each triangle, or none"));
        }
        let is_unknown = |index: &u32| *index as usize >= self.materials.len();
        match self.faces.iter().filter_map(|face| face.material).find(is_unknown) {
            Some(index) => Err(SimError::parameter("material", index, "the index of a material")),
            None => Ok(()),
        }
    }

    /// Light at a point of a triangle with these vertices; the weights of its corners add up to 1.
    pub(super) fn light(&self, vertices: [u32; 3], triangle: usize, weights: [f64; 3]) -> [f32; 3] {
        let weights = weights.map(|weight| weight as f32);
        let mut light = [1.0; 3];
        if !self.vertex_colors.is_empty() {
            light = mean(vertices.map(|i| srgb::to_light(self.vertex_colors[i as usize])), weights);
        }
        let Some(Face { material: Some(material), texture }) = self.faces.get(triangle) else { return light };
        let Material { reflectance, image } = &self.materials[*material as usize];
        light = times(light, *reflectance);
        match image {
            None => light,
            Some(image) => {
                let [u, v] = [0, 1].map(|k| (0..3).map(|i| weights[i] * texture[i][k]).sum::<f32>());
                times(light, texel(image, u, v))
            }
        }
    }
}

/// The light of an image interpolated between its four nearest pixels; the image repeats.
fn texel(image: &ColorImage, u: f32, v: f32) -> [f32; 3] {
    let place = |share: f32, size: u32| {
        let share = if share.is_finite() { share - share.floor() } else { 0.0 };
        let at = share * size as f32 - 0.5;
        let first = (at.floor() as i64).rem_euclid(i64::from(size)) as u32;
        ([first, (first + 1) % size], at - at.floor())
    };
    let (columns, right) = place(u, image.width());
    let (rows, down) = place(1.0 - v, image.height());
    let row = |v: u32| {
        let [left_light, right_light] = columns.map(|u| srgb::to_light(image.get(u, v)));
        mean([left_light, right_light, [0.0; 3]], [1.0 - right, right, 0.0])
    };
    mean([row(rows[0]), row(rows[1]), [0.0; 3]], [1.0 - down, down, 0.0])
}

fn mean(lights: [[f32; 3]; 3], weights: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|channel| (0..3).map(|i| weights[i] * lights[i][channel]).sum())
}

fn times(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|channel| a[channel] * b[channel])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_where_texture_coordinates_say() {
        let pixels = vec![[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]];
        let image = ColorImage::new(2, 2, pixels).unwrap();
        let color = |u: f32, v: f32| srgb::to_color(texel(&image, u, v));
        assert_eq!([color(0.25, 0.75), color(0.75, 0.75)], [[255, 0, 0], [0, 255, 0]], "above");
        assert_eq!([color(0.25, 0.25), color(-0.25, 7.25)], [[0, 0, 255], [255; 3]], "below, repeated");
        assert_eq!(color(0.5, 0.75), srgb::to_color([0.5, 0.5, 0.0]), "light is mixed");
        assert_eq!(color(f32::NAN, f32::INFINITY).len(), 3);
    }

    #[test]
    fn colours_of_vertices_material_and_image_are_multiplied() {
        let image = ColorImage::new(1, 1, vec![[255, 0, 255]]).unwrap();
        let materials = vec![Material { reflectance: [1.0, 1.0, 0.5], image: Some(image) }];
        let faces = vec![Face { material: Some(0), ..Face::default() }, Face::default()];
        let look = Appearance { vertex_colors: vec![[255; 3], [0; 3], [255; 3]], faces, materials };
        look.check(3, 2).unwrap();
        let weights = [0.25, 0.5, 0.25];
        assert_eq!(look.light([0, 1, 2], 0, weights), [0.5, 0.0, 0.25]);
        assert_eq!(look.light([0, 1, 2], 1, weights), [0.5; 3]);
    }

    #[test]
    fn lists_must_fit_the_mesh() {
        let look = Appearance {
            faces: vec![Face { material: Some(1), ..Face::default() }],
            ..Appearance::default()
        };
        assert!(look.check(3, 1).unwrap_err().to_string().contains("material is 1"));
        assert!(look.check(3, 2).unwrap_err().to_string().contains("1 faces of 2 triangles"));
        let look = Appearance { vertex_colors: vec![[0; 3]; 2], ..Appearance::default() };
        assert!(look.check(3, 1).unwrap_err().to_string().contains("2 colours of 3 vertices"));
    }
}
