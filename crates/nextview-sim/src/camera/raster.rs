//! A z-buffer rasteriser that loses no hit. A triangle covers a sample point that lies on the same side of
//! its three edges or on one of them (Pineda 1988). The two triangles at an edge always compute opposite
//! sides, and a point on a corner gets an exact zero. No sample falls between neighbours, regardless of
//! rounding.
//!
//! The image does not depend on the drawing order or on the hidden triangles left out. The clusters nearest
//! to the camera come first, and the clusters they hide are not drawn.

use super::chunk::{Chunk, LANES};
use super::clip::clip;
use super::depth_buffer::DepthBuffer;
use super::draw_list::{Cluster, DrawList};
use super::pixel_box::PixelBox;
use super::projection::{Projected, ProjectedCluster, ToCamera, project};
use super::samples::ImageSamples;
use nextview::geometry::Pose;
use pulp::{Arch, Scalar, Simd, WithSimd};
use std::ops::Range;

/// 1 / depth of the nearest surface at every sample; 0 where there is none, infinite where there is no
/// sample.
pub(super) fn nearest_surfaces(
    samples: &ImageSamples,
    list: &DrawList,
    world_from_camera: &Pose,
) -> Vec<Chunk> {
    let to_camera = ToCamera::new(world_from_camera);
    Arch::new().dispatch(Raster { samples, list, to_camera })
}

/// An image to draw, compiled for several kinds of processors.
#[derive(Clone, Copy)]
struct Raster<'a> {
    samples: &'a ImageSamples,
    list: &'a DrawList,
    to_camera: ToCamera,
}

impl WithSimd for Raster<'_> {
    type Output = Vec<Chunk>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<Chunk> {
        let mut buffer = DepthBuffer::new(self.samples);
        let mut projected = ProjectedCluster::new();
        for cluster in self.front_to_back() {
            projected.project(self.list, cluster, self.to_camera, self.samples.locator());
            if projected.farthest > 0.0 {
                self.draw_in_front(simd, &mut buffer, cluster, &projected);
            } else if projected.nearest > 0.0 {
                self.draw_around(&mut buffer, cluster, &projected);
            }
        }
        buffer.into_nearest()
    }
}

impl Raster<'_> {
    fn front_to_back(&self) -> impl Iterator<Item = &Cluster> {
        let depth_of = |cluster: &Cluster| self.to_camera.point(cluster.center).z;
        let mut order: Vec<(f64, &Cluster)> = self.list.clusters.iter().map(|c| (depth_of(c), c)).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        order.into_iter().map(|(_, cluster)| cluster)
    }

    /// Draws a cluster that lies in front of the camera.
    #[inline(always)]
    fn draw_in_front<S: Simd>(
        &self,
        simd: S,
        buffer: &mut DepthBuffer,
        cluster: &Cluster,
        projected: &ProjectedCluster,
    ) {
        // A mean of the corners' depths may be rounded up.
        let nearest = projected.nearest * (1.0 + 1e-12);
        if projected.bounds.is_empty() || buffer.hides(projected.bounds, nearest) {
            return;
        }
        let triangles = &self.list.triangles[cluster.triangles.clone()];
        // Most triangles of a fine mesh fall between the samples; the others are picked out without a branch.
        let mut with_samples = [(PixelBox::NOTHING, [0; 3]); Cluster::MAX_TRIANGLES];
        let mut n = 0;
        for &triangle in triangles {
            let pixels = projected.pixels(triangle);
            with_samples[n] = (pixels, triangle);
            n += !pixels.is_empty() as usize;
        }
        for &(pixels, triangle) in &with_samples[..n] {
            draw(simd, self.samples, buffer.nearest(), pixels, projected.corners(triangle));
        }
        buffer.update_bounds(projected.bounds);
    }

    /// Draws a cluster that crosses the smallest depth. Such clusters are rare, so this is compiled without
    /// vector instructions.
    #[inline(never)]
    fn draw_around(&self, buffer: &mut DepthBuffer, cluster: &Cluster, projected: &ProjectedCluster) {
        let locator = self.samples.locator();
        for &triangle in &self.list.triangles[cluster.triangles.clone()] {
            let corners = projected.corners(triangle);
            if corners.iter().all(|corner| corner.inverse_depth > 0.0) {
                draw(Scalar, self.samples, buffer.nearest(), projected.pixels(triangle), corners);
                continue;
            }
            let vertex = |i: u16| self.to_camera.point(self.list.vertex(cluster, i));
            let (polygon, n) = clip(triangle.map(vertex));
            let polygon = polygon.map(project);
            let margin = locator.margin(f64::INFINITY, f64::INFINITY);
            // Chunks with all corners of the polygon.
            let x = std::array::from_fn(|i| polygon[i % 4].ideal.x);
            let y = std::array::from_fn(|i| polygon[i % 4].ideal.y);
            let boxes = locator.boxes_of(&x, &y, margin);
            for i in 2..n {
                let pixels = boxes[0].join(boxes[i - 1]).join(boxes[i]);
                let corners = [polygon[0], polygon[i - 1], polygon[i]];
                draw(Scalar, self.samples, buffer.nearest(), pixels, corners);
            }
        }
    }
}

/// Draws a triangle entirely in front of the camera.
#[inline(always)]
fn draw<S: Simd>(
    simd: S,
    samples: &ImageSamples,
    nearest: &mut [Chunk],
    pixels: PixelBox,
    corners: [Projected; 3],
) {
    if pixels.is_empty() {
        return;
    }
    let columns = pixels.columns();
    let chunks = columns.start / LANES..(columns.end - 1) / LANES + 1;
    for row in pixels.rows() {
        let first = row * samples.chunks_in_row();
        let range = first + chunks.start..first + chunks.end;
        let (x, y) = (&samples.x()[range.clone()], &samples.y()[range.clone()]);
        for (i, nearest) in nearest[range].iter_mut().enumerate() {
            let first_column = ((chunks.start + i) * LANES) as f64;
            let lanes = columns.start as f64 - first_column..columns.end as f64 - first_column;
            draw_chunk(simd, &x[i], &y[i], nearest, lanes, &corners);
        }
    }
}

/// Draws a triangle at some of the samples of a chunk. The others are left out because rounding may put them
/// into a triangle seen edge-on that ends before them.
///
/// Vector instructions are explicit: the compiler vectorises a plain loop only at some optimisation levels,
/// and otherwise an image takes three times as long. Closures are avoided, since they are compiled without
/// these instructions.
#[inline(always)]
fn draw_chunk<S: Simd>(
    simd: S,
    x: &Chunk,
    y: &Chunk,
    nearest: &mut Chunk,
    lanes: Range<f64>,
    [a, b, c]: &[Projected; 3],
) {
    const NUMBERS: Chunk = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    let (x, y, numbers) = (S::as_simd_f64s(x).0, S::as_simd_f64s(y).0, S::as_simd_f64s(&NUMBERS).0);
    let (a, b, c) =
        (TriangleCorner::new(simd, a), TriangleCorner::new(simd, b), TriangleCorner::new(simd, c));
    let (first, end) = (simd.splat_f64s(lanes.start), simd.splat_f64s(lanes.end));
    let zero = simd.splat_f64s(0.0);
    for (i, nearest) in S::as_mut_simd_f64s(nearest).0.iter_mut().enumerate() {
        let (to_a, to_b, to_c) =
            (a.seen_from(simd, x[i], y[i]), b.seen_from(simd, x[i], y[i]), c.seen_from(simd, x[i], y[i]));
        let at_a = perp_dot(simd, to_b, to_c);
        let at_b = perp_dot(simd, to_c, to_a);
        let at_c = perp_dot(simd, to_a, to_b);
        let is_left = all(
            simd,
            simd.less_than_or_equal_f64s(zero, at_a),
            simd.less_than_or_equal_f64s(zero, at_b),
            simd.less_than_or_equal_f64s(zero, at_c),
        );
        let is_right = all(
            simd,
            simd.less_than_or_equal_f64s(at_a, zero),
            simd.less_than_or_equal_f64s(at_b, zero),
            simd.less_than_or_equal_f64s(at_c, zero),
        );
        let sum = simd.add_f64s(simd.add_f64s(at_a, at_b), at_c);
        // A triangle seen edge-on has no inside: its sum is 0.
        let has_inside = simd.not_m64s(simd.equal_f64s(sum, zero));
        let is_drawn = simd
            .and_m64s(simd.less_than_or_equal_f64s(first, numbers[i]), simd.less_than_f64s(numbers[i], end));
        let is_inside = all(simd, simd.or_m64s(is_left, is_right), has_inside, is_drawn);
        let weighted = simd.add_f64s(
            simd.add_f64s(simd.mul_f64s(at_a, a.inverse_depth), simd.mul_f64s(at_b, b.inverse_depth)),
            simd.mul_f64s(at_c, c.inverse_depth),
        );
        let inverse_depth = simd.div_f64s(weighted, sum);
        let is_nearer = simd.less_than_f64s(*nearest, inverse_depth);
        *nearest = simd.select_f64s(simd.and_m64s(is_inside, is_nearer), inverse_depth, *nearest);
    }
}

/// A corner of a triangle, in all lanes.
struct TriangleCorner<S: Simd> {
    x: S::f64s,
    y: S::f64s,
    inverse_depth: S::f64s,
}

impl<S: Simd> TriangleCorner<S> {
    #[inline(always)]
    fn new(simd: S, corner: &Projected) -> Self {
        let (x, y) = (simd.splat_f64s(corner.ideal.x), simd.splat_f64s(corner.ideal.y));
        Self { x, y, inverse_depth: simd.splat_f64s(corner.inverse_depth) }
    }

    /// The vectors from samples to the corner.
    #[inline(always)]
    fn seen_from(&self, simd: S, x: S::f64s, y: S::f64s) -> [S::f64s; 2] {
        [simd.sub_f64s(self.x, x), simd.sub_f64s(self.y, y)]
    }
}

/// The length of the cross product of vectors in the plane, with its sign.
#[inline(always)]
fn perp_dot<S: Simd>(simd: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> S::f64s {
    simd.sub_f64s(simd.mul_f64s(a[0], b[1]), simd.mul_f64s(a[1], b[0]))
}

#[inline(always)]
fn all<S: Simd>(simd: S, a: S::m64s, b: S::m64s, c: S::m64s) -> S::m64s {
    simd.and_m64s(simd.and_m64s(a, b), c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use glam::{DQuat, DVec2, DVec3};
    use nextview::geometry::random::Random;
    use nextview::sensor::{Distortion, Intrinsics};

    /// The instructions of every CPU, of this CPU and of most CPUs.
    #[test]
    fn images_have_the_same_bits_with_all_instructions() {
        let mut archs = vec![Arch::Scalar, Arch::new()];
        #[cfg(target_arch = "x86_64")]
        archs.extend(pulp::x86::V3::try_new().map(Arch::V3));
        let mut random = Random::new(3, 0);
        for _ in 0..20 {
            let vertices: Vec<DVec3> = (0..60).map(|_| random.in_cube()).collect();
            let triangles = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let list = DrawList::new(&TriangleMesh::new(vertices, triangles).unwrap());
            let pinhole = Intrinsics::pinhole(45, 31, DVec2::splat(30.0), DVec2::new(22.0, 15.0)).unwrap();
            let lens = Distortion::BrownConrady([0.1, -0.05, 0.002, -0.001, 0.01]);
            let samples = ImageSamples::new(&pinhole.with_distortion(lens).unwrap()).unwrap();
            // Triangles in front of the camera, behind it and around it.
            let position = random.in_cube() * 2.0;
            let pose =
                Pose::new(DQuat::from_rotation_arc(DVec3::Z, -position.normalize()), position).unwrap();
            let to_camera = ToCamera::new(&pose);
            let bits = |arch: &Arch| {
                let image = arch.dispatch(Raster { samples: &samples, list: &list, to_camera });
                image.into_iter().flatten().map(f64::to_bits).collect::<Vec<u64>>()
            };
            let images: Vec<Vec<u64>> = archs.iter().map(bits).collect();
            assert!(images.iter().all(|image| *image == images[0]));
        }
    }
}
