//! The visible part of a mesh in a photo.

use super::normals::smooth;
use super::photo::Photo;
use glam::{DVec2, DVec3};
use nextview::sensor::Depth;
use nextview::{Cancel, Cancelled};

/// Minimum cosine between the normal of a visible triangle and the direction to the camera: 80 degrees.
const LEAST_COSINE: f64 = 0.17;

/// Factor on the quality of a triangle if pixels that it touches may show something else: next to a
/// silhouette, or because no depth was measured there.
const DOUBTFUL: f32 = 0.05;

/// A position in an image: column and row in pixels, and depth in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImagePoint {
    pub pixel: DVec2,
    pub depth: f64,
}

/// A mesh as seen by the camera of a photo.
pub(super) struct PhotoSight {
    /// The position of every vertex; `None` behind the camera.
    pub places: Vec<Option<ImagePoint>>,
    /// The visibility of every triangle: its area in the image in pixels times the cosine of the angle; 0 if
    /// it is not seen.
    pub quality: Vec<f32>,
}

/// Returns four times the mean edge length.
fn tolerance(vertices: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let edge = |&[a, b, _]: &[u32; 3]| vertices[a as usize].distance(vertices[b as usize]);
    4.0 * triangles.iter().map(edge).sum::<f64>() / triangles.len().max(1) as f64
}

/// The mesh to view.
pub(super) struct ViewedMesh<'a> {
    pub vertices: &'a [DVec3],
    pub triangles: &'a [[u32; 3]],
    /// Unit normal of every triangle.
    normals: Vec<DVec3>,
    /// Depth difference up to which two depths belong to one surface, metres.
    pub tolerance: f64,
}

impl<'a> ViewedMesh<'a> {
    pub fn new(vertices: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let (normals, tolerance) = (smooth(vertices, triangles), tolerance(vertices, triangles));
        Self { vertices, triangles, normals, tolerance }
    }

    /// Returns the cosine of the angle at which the camera sees a triangle.
    fn cosine(&self, triangle: usize, camera: DVec3) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|i| self.vertices[i as usize]);
        self.normals[triangle].dot((camera - (a + b + c) / 3.0).normalize_or_zero())
    }
}

impl PhotoSight {
    pub fn new(photo: &Photo, shape: &ViewedMesh, cancel: &Cancel) -> Result<Self, Cancelled> {
        let ViewedMesh { vertices, triangles, tolerance, .. } = *shape;
        let frame = &photo.frame;
        let camera_from_world = frame.world_from_camera().inverse();
        let place = |vertex: &DVec3| {
            let point = camera_from_world.transform_point(*vertex);
            let pixel = frame.intrinsics().project(point).filter(|pixel| pixel.is_finite())?;
            Some(ImagePoint { pixel, depth: point.z })
        };
        let places: Vec<Option<ImagePoint>> = vertices.iter().map(place).collect();
        cancel.check()?;
        let size = [frame.image().width(), frame.image().height()];
        let mesh_depth = depth_buffer(&places, triangles, size);
        cancel.check()?;
        let camera = frame.world_from_camera().translation();
        let quality = triangles.iter().enumerate().map(|(i, triangle)| {
            let cosine = shape.cosine(i, camera);
            let corners = corners(&places, triangle).filter(|_| cosine > LEAST_COSINE)?;
            let clear = clearness(&corners, photo, &mesh_depth, tolerance)?;
            let [a, b, c] = corners.map(|corner| corner.pixel);
            Some((0.5 * (b - a).perp_dot(c - a).abs() * cosine) as f32 * clear)
        });
        let quality = quality.map(Option::unwrap_or_default).collect();
        Ok(Self { places, quality })
    }
}

/// Returns the positions of the corners of a triangle, if all are in front of the camera.
pub(super) fn corners(places: &[Option<ImagePoint>], triangle: &[u32; 3]) -> Option<[ImagePoint; 3]> {
    let [a, b, c] = triangle.map(|i| places[i as usize]);
    Some([a?, b?, c?])
}

/// Returns the depth of the mesh at every pixel, infinite without mesh. Pixels on an edge belong to both
/// sides.
pub(super) fn depth_buffer(
    places: &[Option<ImagePoint>],
    triangles: &[[u32; 3]],
    size: [u32; 2],
) -> Vec<f64> {
    let mut buffer = vec![f64::INFINITY; size[0] as usize * size[1] as usize];
    for corners in triangles.iter().filter_map(|triangle| corners(places, triangle)) {
        let pixels = corners.map(|corner| corner.pixel);
        for (u, v) in pixels_near(pixels, 0.0, size) {
            let Some(weights) = weights(pixels, DVec2::new(f64::from(u), f64::from(v))) else { continue };
            if weights.iter().all(|weight| *weight >= -1e-9) {
                let inverse: f64 = (0..3).map(|i| weights[i] / corners[i].depth).sum();
                let nearest = &mut buffer[(v * size[0] + u) as usize];
                *nearest = nearest.min(1.0 / inverse);
            }
        }
    }
    buffer
}

/// Returns the pixels of an image in the bounding box of a triangle, widened by some pixels.
fn pixels_near(corners: [DVec2; 3], wider: f64, size: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c) - wider, a.max(b).max(c) + wider);
    let range = |low: f64, high: f64, size: u32| {
        let end = (high.floor() + 1.0).clamp(0.0, f64::from(size)) as u32;
        (low.ceil().max(0.0) as u32).min(end)..end
    };
    let columns = range(low.x, high.x, size[0]);
    range(low.y, high.y, size[1]).flat_map(move |v| columns.clone().map(move |u| (u, v)))
}

/// Returns the barycentric weights of the corners at a point; `None` for a triangle without area.
pub(super) fn weights([a, b, c]: [DVec2; 3], point: DVec2) -> Option<[f64; 3]> {
    let area = (b - a).perp_dot(c - a);
    let weight = |from: DVec2, to: DVec2| (to - from).perp_dot(point - from) / area;
    (area != 0.0).then(|| [weight(b, c), weight(c, a), weight(a, b)])
}

/// Whether an interpolated lookup in a triangle may touch this pixel: whether the triangle meets the open
/// square of two pixels around it (separating axes).
pub(super) fn is_touched(corners: [DVec2; 3], pixel: DVec2) -> bool {
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let is_apart = |from: DVec2, to: DVec2, third: DVec2| {
        let normal = (to - from).perp();
        let side = normal.dot(third - from);
        let normal = if side < 0.0 { -normal } else { normal };
        normal.dot(pixel - from) + normal.x.abs() + normal.y.abs() <= 0.0
    };
    let is_in_box =
        (pixel - low).cmpgt(DVec2::splat(-1.0)).all() && (high - pixel).cmpgt(DVec2::splat(-1.0)).all();
    is_in_box && !is_apart(a, b, c) && !is_apart(b, c, a) && !is_apart(c, a, b)
}

/// Returns 1 if all pixels that a triangle touches show it, less if some may show something else; `None` if
/// one shows something else or is outside the image, or if none was measured.
fn clearness(corners: &[ImagePoint; 3], photo: &Photo, mesh_depth: &[f64], tolerance: f64) -> Option<f32> {
    let image = photo.frame.image();
    let size = [image.width(), image.height()];
    let pixels = corners.map(|corner| corner.pixel);
    let last = DVec2::new(f64::from(size[0] - 1), f64::from(size[1] - 1));
    if pixels.iter().any(|pixel| pixel.cmplt(DVec2::ZERO).any() || pixel.cmpgt(last).any()) {
        return None;
    }
    let depths = corners.map(|corner| corner.depth);
    let nearest = depths.into_iter().fold(f64::INFINITY, f64::min) - tolerance;
    let farthest = depths.into_iter().fold(0.0, f64::max) + tolerance;
    let (mut clear, mut is_measured) = (1.0, false);
    for (u, v) in pixels_near(pixels, 1.0, size) {
        if !is_touched(pixels, DVec2::new(f64::from(u), f64::from(v))) {
            continue;
        }
        let of_mesh = mesh_depth[(v * size[0] + u) as usize];
        if of_mesh < nearest {
            return None;
        }
        match image.get(u, v) {
            Depth::Surface(depth) if !(nearest..=farthest).contains(&f64::from(depth)) => return None,
            Depth::Surface(_) => is_measured = true,
            Depth::Beyond | Depth::Missing => clear = DOUBTFUL,
        }
        if of_mesh > farthest {
            clear = DOUBTFUL;
        }
    }
    is_measured.then_some(clear)
}
