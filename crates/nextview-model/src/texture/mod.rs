//! A mesh with a texture from photos (Waechter et al. 2014, "Let there be color!"; Lempitsky & Ivanov 2007).
//!
//! Each triangle takes its colour from one photo, connected triangles of one photo form a chart, and charts
//! are copied from their photos into one image. Unlike in the papers, labels are chosen by local search
//! instead of graph cuts, and seams are levelled only at the vertices, without Poisson editing.

mod atlas;
mod charts;
mod exposure;
mod labels;
mod neighbors;
mod normals;
mod obj;
mod packing;
mod photo;
mod seams;
mod sight;
#[cfg(test)]
mod tests;
mod textured_mesh;
mod unseen;

pub use obj::{write_mtl, write_obj};
pub use photo::Photo;
pub use textured_mesh::TexturedMesh;

use glam::DVec3;
use nextview::surface::CloudPoint;
use nextview::{Cancel, Error};
use rayon::prelude::*;
use sight::{PhotoSight, ViewedMesh};

/// Largest side of the texture, pixels; charts are scaled down if they do not fit.
const MAX_SIDE: usize = 4096;

/// Textures a mesh, in metres, from photos.
///
/// A photo sees a triangle if it is in the image, faces the camera, is measured there, and is hidden neither
/// by the mesh nor by anything else. Each triangle uses a photo that shows it large and from the front, and
/// that its neighbours use. A gain for each photo levels exposure differences; corrections that fade inside
/// the charts level the rest at seams. Triangles that no photo sees get the colours of their vertices, or of
/// surrounding vertices.
///
/// ```
/// use glam::DVec3;
/// use nextview::Cancel;
/// use nextview::surface::CloudPoint;
/// use nextview_model::texture_mesh;
///
/// let red = |position: DVec3| CloudPoint { color: Some([255, 0, 0]), ..position.into() };
/// let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y].map(red);
/// let mesh = texture_mesh(&vertices, &[[0, 1, 2]], &[], &Cancel::default()).unwrap();
/// assert_eq!(mesh.texture.get(1, 1), [255, 0, 0]);
/// ```
///
/// Fails if a triangle refers to a nonexistent vertex, if a vertex is not finite, if a colour image differs
/// in size from its depth image, or if the mesh has more triangles than fit into the texture.
pub fn texture_mesh(
    vertices: &[CloudPoint],
    triangles: &[[u32; 3]],
    photos: &[Photo],
    cancel: &Cancel,
) -> Result<TexturedMesh, Error> {
    photos.iter().try_for_each(|photo| photo.color.check_fits(photo.frame.image()))?;
    if let Some(index) = triangles.iter().flatten().find(|index| **index as usize >= vertices.len()) {
        return Err(Error::invalid("vertex of a triangle", index, "a vertex that exists"));
    }
    let positions: Vec<DVec3> = vertices.iter().map(|vertex| vertex.position).collect();
    if let Some(position) = positions.iter().find(|position| !position.is_finite()) {
        return Err(Error::invalid("vertex", position, "finite numbers of metres"));
    }
    let shape = ViewedMesh::new(&positions, triangles);
    let look = |photo| PhotoSight::new(photo, &shape, cancel);
    let sights: Vec<PhotoSight> = photos.par_iter().map(look).collect::<Result<_, _>>()?;
    let neighbors = neighbors::of_triangles(triangles);
    let labels = labels::best_photos(&sights, &neighbors, cancel)?;
    let charts = charts::charts(triangles, &labels, &neighbors);
    let gains = exposure::gains(photos, &sights, &shape, cancel)?;
    let levelled = seams::level(photos, &sights, triangles, &charts, &gains, cancel)?;
    let unseen: Vec<usize> = (0..triangles.len()).filter(|i| labels[*i].is_none()).collect();
    let colors = match unseen.is_empty() {
        true => Vec::new(),
        false => unseen::vertex_colors(vertices, triangles, &levelled.vertex_colors, cancel)?,
    };
    let layout = packing::TextureLayout::new(&charts, &sights, unseen.len(), MAX_SIDE)?;
    let mut atlas = atlas::Atlas::new(layout, triangles);
    for (i, chart) in charts.iter().enumerate() {
        cancel.check()?;
        atlas.draw(
            i,
            chart,
            &photos[chart.photo],
            &sights[chart.photo],
            &levelled.corrections[i],
            gains[chart.photo],
        );
    }
    atlas.draw_unseen(&unseen, &colors);
    atlas.into_mesh(positions)
}
