use super::chunk::{Chunk, LANES, larger, smaller};
use super::draw_list::{Cluster, DrawList};
use super::locator::PixelLocator;
use super::pixel_box::PixelBox;
use glam::{DMat3, DVec2, DVec3};
use nextview::geometry::Pose;

/// Surfaces nearer than this are not seen, metres.
pub(super) const MIN_DEPTH: f64 = 1e-3;

/// A vertex seen by the camera.
#[derive(Clone, Copy)]
pub(super) struct Projected {
    pub ideal: DVec2,
    /// 1 / depth; 0 for a vertex nearer than [`MIN_DEPTH`] or behind the camera.
    pub inverse_depth: f64,
}

/// From world to camera coordinates, in the form that is fastest for many points.
#[derive(Clone, Copy)]
pub(super) struct ToCamera {
    rotation: DMat3,
    translation: DVec3,
}

impl ToCamera {
    pub fn new(world_from_camera: &Pose) -> Self {
        let camera_from_world = world_from_camera.inverse();
        Self { rotation: camera_from_world.rotation_matrix(), translation: camera_from_world.translation() }
    }

    #[inline(always)]
    pub fn point(&self, world: DVec3) -> DVec3 {
        self.rotation * world + self.translation
    }
}

/// A point of the camera frame.
#[inline(always)]
pub(super) fn project(point: DVec3) -> Projected {
    let inverse_depth = 1.0 / point.z;
    let ideal = point.truncate() * inverse_depth;
    if point.z >= MIN_DEPTH {
        Projected { ideal, inverse_depth }
    } else {
        Projected { ideal: DVec2::ZERO, inverse_depth: 0.0 }
    }
}

/// The vertices of one cluster seen by the camera; the arrays are used up to the cluster's number of chunks.
pub(super) struct ProjectedCluster {
    x: [Chunk; Cluster::MAX_CHUNKS],
    y: [Chunk; Cluster::MAX_CHUNKS],
    inverse_depth: [Chunk; Cluster::MAX_CHUNKS],
    boxes: [[PixelBox; LANES]; Cluster::MAX_CHUNKS],
    /// The inverse depth of the nearest vertex.
    pub nearest: f64,
    /// The inverse depth of the farthest vertex; 0 if any is nearer than [`MIN_DEPTH`] or behind the camera.
    pub farthest: f64,
    /// Holds every sample in the cluster's triangles.
    pub bounds: PixelBox,
}

impl ProjectedCluster {
    /// Creates room for any cluster.
    pub fn new() -> Self {
        let zeros = [[0.0; LANES]; Cluster::MAX_CHUNKS];
        let boxes = [[PixelBox::NOTHING; LANES]; Cluster::MAX_CHUNKS];
        let bounds = PixelBox::NOTHING;
        Self { x: zeros, y: zeros, inverse_depth: zeros, boxes, nearest: 0.0, farthest: 0.0, bounds }
    }

    /// Projects another cluster.
    #[inline(always)]
    pub fn project(
        &mut self,
        list: &DrawList,
        cluster: &Cluster,
        to_camera: ToCamera,
        locator: &PixelLocator,
    ) {
        let vertices = &list.vertices[cluster.vertices.clone()];
        let n = vertices.len();
        let (x, y) = (&mut self.x[..n], &mut self.y[..n]);
        let (inverse_depth, boxes) = (&mut self.inverse_depth[..n], &mut self.boxes[..n]);
        let (mut nearest, mut farthest, mut reach) = ([0.0; LANES], [f64::INFINITY; LANES], [0.0; LANES]);
        for i in 0..n {
            let seen = project_chunk(&vertices[i], to_camera);
            (x[i], y[i], inverse_depth[i]) = (seen[0], seen[1], seen[2]);
            for lane in 0..LANES {
                nearest[lane] = larger(seen[2][lane], nearest[lane]);
                farthest[lane] = smaller(seen[2][lane], farthest[lane]);
            }
            locator.reach(&x[i], &y[i], &mut reach);
        }
        self.nearest = nearest.into_iter().fold(0.0, larger);
        self.farthest = farthest.into_iter().fold(f64::INFINITY, smaller);
        let reach = reach.into_iter().fold(0.0, larger);
        // Between the ends of an edge x/z changes by the change of x over z, and by x/z times the change of z
        // over z.
        let extent = cluster.longest_edge * self.nearest * (1.0 + locator.farthest(reach));
        let margin = locator.margin(extent, reach);
        for i in 0..n {
            boxes[i] = locator.boxes_of(&x[i], &y[i], margin);
        }
        self.bounds = boxes.as_flattened().iter().fold(PixelBox::NOTHING, |all, pixels| all.join(*pixels));
    }

    /// Returns the corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: [u16; 3]) -> [Projected; 3] {
        let (x, y) = (self.x.as_flattened(), self.y.as_flattened());
        triangle.map(|i| {
            let i = i as usize;
            Projected { ideal: DVec2::new(x[i], y[i]), inverse_depth: self.inverse_depth.as_flattened()[i] }
        })
    }

    /// The box of every sample in a triangle without a corner behind the camera.
    #[inline(always)]
    pub fn pixels(&self, [a, b, c]: [u16; 3]) -> PixelBox {
        let boxes = self.boxes.as_flattened();
        boxes[a as usize].join(boxes[b as usize]).join(boxes[c as usize])
    }
}

/// Ideal x and y and inverse depth of vertices in world coordinates.
#[inline(always)]
fn project_chunk(world: &[Chunk; 3], to_camera: ToCamera) -> [Chunk; 3] {
    let [mut x, mut y, mut inverse_depth] = [[0.0; LANES]; 3];
    for i in 0..LANES {
        let seen = project(to_camera.point(DVec3::new(world[0][i], world[1][i], world[2][i])));
        (x[i], y[i], inverse_depth[i]) = (seen.ideal.x, seen.ideal.y, seen.inverse_depth);
    }
    [x, y, inverse_depth]
}
