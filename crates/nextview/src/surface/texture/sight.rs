//! What a photo sees of a mesh.

use super::normals::smooth;
use super::photo::Photo;
use crate::sensor::Depth;
use crate::{Cancel, Cancelled};
use glam::{DVec2, DVec3};

/// Cosine between the normal and the direction to the camera below which a triangle is not seen: 80 degrees.
const LEAST_COSINE: f64 = 0.17;

/// What the quality of a triangle is worth if pixels that it touches may show something else: beside a
/// silhouette, or because no depth was measured there.
const DOUBTFUL: f32 = 0.05;

/// A place of an image: column and row in pixels, and depth in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub pixel: DVec2,
    pub depth: f64,
}

/// A mesh seen by the camera of a photo.
pub(super) struct Sight {
    /// Of every vertex; none behind the camera.
    pub places: Vec<Option<Place>>,
    /// Of every triangle: how well it is seen, its area in the image in pixels times the cosine of the angle;
    /// 0 if it is not seen.
    pub quality: Vec<f32>,
}

/// Four times the mean edge.
fn tolerance(vertices: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let edge = |&[a, b, _]: &[u32; 3]| vertices[a as usize].distance(vertices[b as usize]);
    4.0 * triangles.iter().map(edge).sum::<f64>() / triangles.len().max(1) as f64
}

/// What is to be seen.
pub(super) struct Shape<'a> {
    pub vertices: &'a [DVec3],
    pub triangles: &'a [[u32; 3]],
    /// Unit normal of every triangle.
    normals: Vec<DVec3>,
    /// Difference of depths up to which they are of one surface, metres.
    pub tolerance: f64,
}

impl<'a> Shape<'a> {
    pub fn new(vertices: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let (normals, tolerance) = (smooth(vertices, triangles), tolerance(vertices, triangles));
        Self { vertices, triangles, normals, tolerance }
    }

    /// Cosine of the angle at which a triangle is seen from there.
    fn cosine(&self, triangle: usize, camera: DVec3) -> f64 {
        let [a, b, c] = self.triangles[triangle].map(|i| self.vertices[i as usize]);
        self.normals[triangle].dot((camera - (a + b + c) / 3.0).normalize_or_zero())
    }
}

impl Sight {
    pub fn new(photo: &Photo, shape: &Shape, cancel: &Cancel) -> Result<Self, Cancelled> {
        let Shape { vertices, triangles, tolerance, .. } = *shape;
        let frame = &photo.frame;
        let camera_from_world = frame.world_from_camera().inverse();
        let place = |vertex: &DVec3| {
            let point = camera_from_world.transform_point(*vertex);
            let pixel = frame.intrinsics().project(point).filter(|pixel| pixel.is_finite())?;
            Some(Place { pixel, depth: point.z })
        };
        let places: Vec<Option<Place>> = vertices.iter().map(place).collect();
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

/// The places of the corners of a triangle, if all are before the camera.
pub(super) fn corners(places: &[Option<Place>], triangle: &[u32; 3]) -> Option<[Place; 3]> {
    let [a, b, c] = triangle.map(|i| places[i as usize]);
    Some([a?, b?, c?])
}

/// Depth of the mesh at every pixel, infinite where it is not. Pixels on an edge belong to both sides.
pub(super) fn depth_buffer(places: &[Option<Place>], triangles: &[[u32; 3]], size: [u32; 2]) -> Vec<f64> {
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

/// The pixels of an image in the box around a triangle that is wider by some pixels.
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

/// The weights of the corners at a point of their plane; none of a triangle without area.
pub(super) fn weights([a, b, c]: [DVec2; 3], point: DVec2) -> Option<[f64; 3]> {
    let area = (b - a).perp_dot(c - a);
    let weight = |from: DVec2, to: DVec2| (to - from).perp_dot(point - from) / area;
    (area != 0.0).then(|| [weight(b, c), weight(c, a), weight(a, b)])
}

/// Whether a lookup between pixels somewhere in a triangle may touch this pixel: whether the triangle meets
/// the square of two pixels around it, without its border (separating axes).
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

/// 1 if all pixels that a triangle touches show it, less if some may show something else, none if one does or
/// is outside the image, or if none was measured.
fn clearness(corners: &[Place; 3], photo: &Photo, mesh_depth: &[f64], tolerance: f64) -> Option<f32> {
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
