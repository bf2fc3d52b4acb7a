use crate::Outcome;
use glam::{DVec2, DVec3};
use nextview::geometry::{Aabb, Lattice, Pose, SegmentWalk, VoxelBlock, VoxelKey};
use nextview::sensor::Intrinsics;
use rayon::prelude::*;

/// Edge of a voxel of the true shape, in metres.
const VOXEL_SIZE: f64 = 0.002;

/// Step in columns and rows between background points, among the pixels that miss the object: 4 mm at 0.4 m.
const EVERY: usize = 6;

/// Depth of the background, in metres: beyond the box from everywhere.
const FAR: f64 = 1.0;

/// The virtual camera: each pixel's ray ends in the first voxel of 2 mm that holds surface, and the image
/// shows the voxel's centre, without noise.
pub struct VirtualCamera {
    lattice: Lattice,
    block: VoxelBlock,
    is_surface: Vec<bool>,
    width: usize,
    /// Intersection of each pixel's ray with the camera's plane z = 1, row after row; `None` if the lens has
    /// no answer.
    rays: Vec<Option<DVec2>>,
}

/// An image of the camera.
pub struct CameraImage {
    /// The centres of the visible voxels, each once, in the order of the voxels.
    pub points: Vec<DVec3>,
    /// Points beyond the object on rays that miss it, if requested.
    pub background: Vec<DVec3>,
}

impl VirtualCamera {
    /// Creates a camera in front of the object made of these voxels of 2 mm.
    pub fn new(surface: &[VoxelKey], intrinsics: &Intrinsics) -> Outcome<Self> {
        let start = (VoxelKey::MAX, VoxelKey::MIN);
        let (low, high) = surface.iter().fold(start, |(low, high), &key| (low.min(key), high.max(key)));
        let size = (high - low + 1).as_uvec3();
        let block = VoxelBlock::new(low, size).ok_or_else(|| format!("a shape of {size} voxels of 2 mm"))?;
        let mut is_surface = vec![false; block.n_voxels()];
        surface.iter().filter_map(|&key| block.index(key)).for_each(|voxel| is_surface[voxel] = true);
        let pixels = (0..intrinsics.height()).flat_map(|v| (0..intrinsics.width()).map(move |u| (u, v)));
        let rays = pixels.map(|(u, v)| intrinsics.deproject(DVec2::new(u.into(), v.into()))).collect();
        let (lattice, width) = (Lattice::new(VOXEL_SIZE)?, intrinsics.width() as usize);
        Ok(Self { lattice, block, is_surface, width, rays })
    }

    /// Takes an image from this pose, with or without the background.
    pub fn scan(&self, world_from_camera: &Pose, with_background: bool) -> CameraImage {
        let background = if with_background { self.background(world_from_camera) } else { Vec::new() };
        CameraImage { points: self.points(world_from_camera), background }
    }

    fn points(&self, world_from_camera: &Pose) -> Vec<DVec3> {
        let rotation = world_from_camera.rotation_matrix();
        let from = self.lattice.to_voxels(world_from_camera.translation());
        let (low, high) = self.outline(world_from_camera);
        let shows = |ray: &DVec2| ray.cmpge(low).all() && ray.cmple(high).all();
        let rays = self.rays.par_iter().filter_map(|ray| ray.filter(shows));
        let mut hits: Vec<usize> =
            rays.filter_map(|ray| self.first_hit(from, rotation * ray.extend(1.0))).collect();
        hits.sort_unstable();
        hits.dedup();
        hits.into_iter().map(|voxel| self.lattice.center(self.block.key(voxel))).collect()
    }

    fn background(&self, world_from_camera: &Pose) -> Vec<DVec3> {
        let (position, rotation) = (world_from_camera.translation(), world_from_camera.rotation_matrix());
        let from = self.lattice.to_voxels(position);
        let sparse = self.rays.chunks(self.width).step_by(EVERY).flat_map(|row| row.iter().step_by(EVERY));
        let directions = sparse.flatten().map(|ray| rotation * ray.extend(1.0));
        let missing = directions.filter(|&direction| self.first_hit(from, direction).is_none());
        missing.map(|direction| position + direction * FAR).collect()
    }

    /// The part of the plane z = 1 that shows the object, from low to high.
    fn outline(&self, world_from_camera: &Pose) -> (DVec2, DVec2) {
        let (to_camera, bounds): (Pose, Aabb) =
            (world_from_camera.inverse(), self.lattice.bounds(&self.block));
        let corners = bounds.corners().map(|corner| to_camera.transform_point(corner));
        if corners.iter().any(|corner| corner.z <= 0.0) {
            return (DVec2::NEG_INFINITY, DVec2::INFINITY);
        }
        let corners = corners.map(|corner| corner.truncate() / corner.z);
        let widen = DVec2::splat(1e-3);
        let low = corners.iter().fold(DVec2::INFINITY, |low, &corner| low.min(corner));
        (low - widen, corners.iter().fold(DVec2::NEG_INFINITY, |high, &corner| high.max(corner)) + widen)
    }

    fn first_hit(&self, from: DVec3, direction: DVec3) -> Option<usize> {
        let mut walk = SegmentWalk::ray_within(from, direction, self.block.min(), self.block.max())?;
        loop {
            let voxel = self.block.index(walk.key())?;
            if self.is_surface[voxel] {
                return Some(voxel);
            }
            walk.advance()?;
        }
    }
}
