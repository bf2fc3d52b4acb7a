use super::Slips;
use super::camera::look_from;
use super::outline::Outline;
use super::recording::{RecordedRun, VOXEL_SIZE};
use crate::Outcome;
use glam::DVec3;
use nextview::geometry::{Aabb, Lattice, Pose, SegmentWalk, VoxelBlock, VoxelKey};
use nextview::sensor::Intrinsics;
use rayon::prelude::*;
use std::collections::HashMap;

/// Number of voxels between two rays of a view.
const APART: f64 = 10.0;

/// The planning rays of all views. Rays of different views that cross the box from the same first to the same
/// last voxel are one.
pub struct PlanningRays {
    /// By ray, the box's voxels along it, in order.
    pub voxels: Vec<Vec<u32>>,
    /// By view, its rays, each once, in increasing order.
    pub of_view: Vec<Vec<u32>>,
}

/// Casts rays through a map.
pub struct RayCaster<'a> {
    /// The box, the voxels that exist, and the views.
    pub recording: &'a RecordedRun,
    /// The camera that defines the rays by its pixels.
    pub intrinsics: &'a Intrinsics,
    /// The program's slips.
    pub slips: Slips,
    /// By existing voxel, whether rays end in it.
    pub is_end: &'a [bool],
}

impl RayCaster<'_> {
    /// Casts the rays of all views, with their roll after this camera.
    pub fn cast(&self, before: &Pose) -> Outcome<PlanningRays> {
        // Errors that may pass between threads.
        let one = |&position: &DVec3| -> Result<_, String> {
            let camera = look_from(position, self.recording.center, before).map_err(|e| e.to_string())?;
            self.cast_view(&camera).map_err(|e| e.to_string())
        };
        let views: Vec<Vec<Vec<u32>>> =
            self.recording.positions.par_iter().map(one).collect::<Result<_, _>>()?;
        let mut rays = PlanningRays { voxels: Vec::new(), of_view: Vec::new() };
        let mut numbers = HashMap::new();
        for view in views {
            let mut of_view: Vec<u32> = Vec::new();
            for voxels in view {
                let ends = (voxels[0], voxels[voxels.len() - 1]);
                let next = rays.voxels.len() as u32;
                let number = *numbers.entry(ends).or_insert(next);
                if number == next {
                    rays.voxels.push(voxels);
                }
                of_view.push(number);
            }
            of_view.sort_unstable();
            of_view.dedup();
            rays.of_view.push(of_view);
        }
        Ok(rays)
    }

    /// The voxels of the box on each ray of a view; rays without any are left out.
    fn cast_view(&self, camera: &Pose) -> Outcome<Vec<Vec<u32>>> {
        let aabb = Aabb::cube(self.recording.center, self.recording.half);
        let outline = Outline::new(&aabb, camera, self.intrinsics, self.slips.outline_by_deprojection)?;
        // The authors count whole pixels per voxel.
        let pixels = outline.pixels(APART * outline.voxel_pixels.floor().max(1.0)).into_iter();
        let (rotation, lattice) = (camera.rotation_matrix(), Lattice::new(VOXEL_SIZE)?);
        let from = lattice.to_voxels(camera.translation());
        let seen = pixels.filter(|&pixel| self.slips.rays_outside_image || self.intrinsics.contains(pixel));
        let directions =
            seen.filter_map(|pixel| Some(rotation * self.intrinsics.deproject(pixel)?.extend(1.0)));
        let rays = directions.filter_map(|direction| self.first_end(from, direction));
        Ok(rays.map(|voxels| self.in_box(voxels)).filter(|voxels| !voxels.is_empty()).collect())
    }

    /// The existing voxels up to the first end of a ray. With the slip these are the voxels on the way to the
    /// end's centre, and a ray without an end does not exist; otherwise those on the pixel's ray.
    fn first_end(&self, from: DVec3, direction: DVec3) -> Option<Vec<VoxelKey>> {
        let exist = self.recording.created;
        let mut walk = SegmentWalk::ray_within(from, direction, exist.min(), exist.max())?;
        let mut keys = vec![walk.key()];
        while !self.is_end[exist.index(walk.key())?] && walk.advance().is_some() {
            keys.push(walk.key());
        }
        if !self.slips.rays_stop_at_unknown {
            return Some(keys);
        }
        self.is_end[exist.index(walk.key())?].then(|| on_the_way(from, walk.key(), exist))
    }

    fn in_box(&self, keys: Vec<VoxelKey>) -> Vec<u32> {
        keys.into_iter().filter_map(|key| Some(self.recording.block.index(key)? as u32)).collect()
    }
}

/// The existing voxels between a position and the centre of a voxel.
fn on_the_way(from: DVec3, end: VoxelKey, exist: VoxelBlock) -> Vec<VoxelKey> {
    let center = end.as_dvec3() + 0.5;
    let mut keys = Vec::new();
    let mut walk = SegmentWalk::within(from, center, exist.min(), exist.max());
    while let Some(at) = &mut walk {
        keys.push(at.key());
        if at.advance().is_none() {
            break;
        }
    }
    keys
}
