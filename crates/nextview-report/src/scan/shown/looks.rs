//! Number and quality of looks at each vertex of the surface.

use super::vertex::ShownVertex;
use crate::scan::scan_copy::ScanCopy;
use nextview::sensor::{ColorImage, Depth, Frame};
use nextview::surface::CloudPoint;
use nextview_model::SurfaceMesh;

/// Cosine of the flattest angle at which a frame shows a vertex.
const FLATTEST: f64 = 0.1;

/// Maximum distance of a measured depth from its vertex, in cells.
const TOLERANCE: f64 = 2.0;

/// The vertices of a surface with their looks. The surface was made with cells of edge `cell`, metres.
pub(super) fn vertices(scan: &ScanCopy, mesh: &SurfaceMesh, cell: f64) -> Vec<ShownVertex> {
    let points = mesh.points();
    let mut vertices: Vec<ShownVertex> = points
        .iter()
        .map(|point| ShownVertex { position: point.position, ..ShownVertex::default() })
        .collect();
    for (frame, step_idx, color) in scan.model_views() {
        // Surface shown by the earlier scan is known from the beginning.
        let step_idx = step_idx.unwrap_or(0);
        look(frame, color, step_idx, TOLERANCE * cell, points.iter().zip(&mut vertices));
    }
    vertices
}

/// Adds the surface shown by a frame.
fn look<'v>(
    frame: &Frame,
    color: Option<&ColorImage>,
    step_idx: usize,
    tolerance: f64,
    vertices: impl Iterator<Item = (&'v CloudPoint, &'v mut ShownVertex)>,
) {
    let camera_from_world = frame.world_from_camera().inverse();
    let camera = frame.world_from_camera().translation();
    for (point, vertex) in vertices {
        let Some(normal) = point.normal else { continue };
        let cosine = normal.dot((camera - point.position).normalize_or_zero());
        if cosine < FLATTEST {
            continue;
        }
        let in_camera = camera_from_world.transform_point(point.position);
        let Some((u, v)) = pixel(frame, in_camera) else { continue };
        let Depth::Surface(depth) = frame.image().get(u, v) else { continue };
        if (f64::from(depth) - in_camera.z).abs() > tolerance {
            continue;
        }
        vertex.n_looks += 1;
        vertex.first_step = Some(vertex.first_step.map_or(step_idx, |first| first.min(step_idx)));
        if cosine > vertex.best_cosine {
            vertex.best_cosine = cosine;
            vertex.color = color.map(|color| color.get(u, v)).or(vertex.color);
        }
    }
}

/// The pixel of a point in front of the camera; `None` outside the image.
fn pixel(frame: &Frame, point_in_camera: glam::DVec3) -> Option<(u32, u32)> {
    let at = frame.intrinsics().project(point_in_camera)?.round();
    let size = glam::DVec2::new(frame.image().width() as f64, frame.image().height() as f64);
    (at.cmpge(glam::DVec2::ZERO).all() && at.cmplt(size).all()).then_some((at.x as u32, at.y as u32))
}
