//! The true object, and the part of it that each view candidate truly sees.

use crate::SimError;
use crate::camera::{Look, SimulatedCamera};
use crate::mesh::TriangleMesh;
use crate::overlap::VoxelTriangle;
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::Error;
use nextview::geometry::{Lattice, Pose, VoxelBlock, VoxelKey};
use nextview::map::{Occupancy, Snapshot};
use nextview::sensor::Frame;
use nextview::view::ViewSpace;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// The voxels of the true surface: exactly those that hold at least one point of it.
///
/// A surface in the face between two voxels belongs to the voxel that [`Lattice::key`] assigns its points to.
/// Half of the measured points of such a surface are in the other voxel, only because image depths are
/// rounded; a map with that voxel is not wrong. Voxels within a micrometre of the surface are therefore a
/// separate kind: neither object voxels nor false. (The paper takes the voxels of many random points of the
/// surface. However dense these are, they miss voxels that the surface crosses only at a corner; a camera
/// finds them, and they count as false.)
#[derive(Clone, Debug)]
pub struct ObjectVoxels {
    lattice: Lattice,
    block: VoxelBlock,
    /// For each voxel of the block, its number among the object voxels, `TOUCHED` or `NO_OBJECT`.
    number: Vec<u32>,
    n_voxels: usize,
}

const NO_OBJECT: u32 = u32::MAX;
const TOUCHED: u32 = NO_OBJECT - 1;

/// Rounding of measured points within a camera's range of 10 m, metres: depths have 24 bits.
const ROUNDING: f64 = 1e-6;

impl ObjectVoxels {
    /// Determines the object voxels of a mesh within the block.
    pub fn new(mesh: &TriangleMesh, lattice: Lattice, block: VoxelBlock) -> Self {
        let number: Vec<AtomicU32> =
            (0..block.n_voxels()).into_par_iter().map(|_| AtomicU32::new(NO_OBJECT)).collect();
        (0..mesh.triangles().len()).into_par_iter().for_each(|i| {
            let triangle = VoxelTriangle::new(mesh.corners(i), &lattice);
            let mark = |voxel, as_: u32| {
                let index = block.index(voxel).expect("voxels of the block are visited");
                number[index].fetch_min(as_, Ordering::Relaxed);
            };
            triangle.for_each_voxel_within(ROUNDING / lattice.voxel_size(), &block, |v| mark(v, TOUCHED));
            triangle.for_each_voxel(&block, |voxel| mark(voxel, 0));
        });
        let mut number: Vec<u32> = number.into_iter().map(AtomicU32::into_inner).collect();
        let mut n_voxels = 0;
        for number in number.iter_mut().filter(|number| **number == 0) {
            *number = n_voxels as u32;
            n_voxels += 1;
        }
        Self { lattice, block, number, n_voxels }
    }

    /// Returns the number of object voxels.
    pub fn len(&self) -> usize {
        self.n_voxels
    }

    /// Returns the block of the object voxels.
    pub fn block(&self) -> VoxelBlock {
        self.block
    }

    /// Returns whether the block holds no object voxels.
    pub fn is_empty(&self) -> bool {
        self.n_voxels == 0
    }

    /// Returns the number of a voxel among the object voxels; `None` for other voxels.
    pub fn number(&self, voxel: VoxelKey) -> Option<usize> {
        let number = self.number[self.block.index(voxel)?];
        (number < TOUCHED).then_some(number as usize)
    }

    /// Returns whether a voxel of the block is false if occupied: not an object voxel, and not within the
    /// rounding of measured points of the surface. Voxels beyond the block are not false.
    pub fn is_false(&self, voxel: VoxelKey) -> bool {
        self.block.index(voxel).is_some_and(|index| self.number[index] == NO_OBJECT)
    }

    /// Returns the object voxels that hold a measured point of the frame.
    pub fn seen_in(&self, frame: &Frame) -> FixedBitSet {
        self.hit_by(frame.points_in(self.lattice.bounds(&self.block)))
    }

    /// Returns the object voxels in the true measurement of a frame from a pose, in less time than a capture.
    pub fn seen_from(&self, camera: &SimulatedCamera, pose: &Pose) -> Result<FixedBitSet, Error> {
        Ok(self.seen_by(&camera.look(pose)?))
    }

    /// Returns the object voxels that hold a measured point of a look.
    pub fn seen_by(&self, look: &Look<'_>) -> FixedBitSet {
        self.hit_by(look.points_in(self.lattice.bounds(&self.block)))
    }

    /// Compares a map with the object, and with its reachable voxels if they are known. The snapshot must be
    /// of the same block.
    pub fn compare(&self, snapshot: &Snapshot, reachable: Option<&FixedBitSet>) -> VoxelScore {
        assert_eq!(snapshot.block(), self.block, "map and truth must cover the same voxels");
        let mut score = VoxelScore { n_object: self.n_voxels, ..VoxelScore::default() };
        let mut n_reached = 0;
        for (number, occupancy) in self.number.iter().zip(snapshot.occupancy()) {
            if *occupancy == Occupancy::Occupied {
                score.n_true += (*number < TOUCHED) as usize;
                score.n_false += (*number == NO_OBJECT) as usize;
                n_reached += reachable.is_some_and(|voxels| voxels.contains(*number as usize)) as usize;
            }
        }
        score.reachable = reachable.map(|voxels| (n_reached, voxels.count_ones(..)));
        score
    }

    fn hit_by(&self, points: impl Iterator<Item = DVec3>) -> FixedBitSet {
        let mut hit = FixedBitSet::with_capacity(self.n_voxels);
        points.filter_map(|point| self.number_at(point)).for_each(|number| hit.insert(number));
        hit
    }

    fn number_at(&self, point: DVec3) -> Option<usize> {
        self.number(self.lattice.key(point))
    }
}

/// Occupied voxels of a map, counted against the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VoxelScore {
    /// Number of object voxels.
    pub n_object: usize,
    /// Number of occupied voxels that are object voxels.
    pub n_true: usize,
    /// Number of occupied voxels that are [false](ObjectVoxels::is_false).
    pub n_false: usize,
    /// Number of occupied and number of all object voxels that any view candidate sees; `None` if these are
    /// not known.
    pub reachable: Option<(usize, usize)>,
}

impl VoxelScore {
    /// Returns the paper's voxel coverage, 0..=1, counting only true voxels: the recall over the whole
    /// object.
    pub fn coverage(&self) -> f64 {
        self.n_true as f64 / self.n_object as f64
    }

    /// Returns the share, 0..=1, of true voxels among the true and false ones; `None` if there are neither.
    pub fn precision(&self) -> Option<f64> {
        share(self.n_true, self.n_true + self.n_false)
    }

    /// Returns the share, 0..=1, of the reachable object voxels that are occupied; `None` if they are not
    /// known.
    pub fn recall(&self) -> Option<f64> {
        let (n_reached, n_reachable) = self.reachable?;
        share(n_reached, n_reachable)
    }

    /// Returns the intersection over union, 0..=1, of the occupied and the reachable object voxels; `None` if
    /// the latter are not known. Occupied object voxels that no candidate sees are in neither: they are
    /// right, but not required.
    pub fn iou(&self) -> Option<f64> {
        let (n_reached, n_reachable) = self.reachable?;
        share(n_reached, n_reachable + self.n_false)
    }
}

fn share(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// The object voxels that each view candidate truly sees, known only to the clairvoyant planner. A camera
/// with noise loses the same pixels here as when it takes its frame.
#[derive(Clone, Debug)]
pub struct TrueVisibility {
    /// Object voxels that each view sees.
    seen: Vec<FixedBitSet>,
    /// Object voxels that any view sees.
    reachable: FixedBitSet,
}

impl TrueVisibility {
    /// Renders the object from every candidate. `progress` is called after each view, from several threads.
    pub fn new(
        camera: &SimulatedCamera,
        object: &ObjectVoxels,
        views: &ViewSpace,
        progress: impl Fn() + Sync,
    ) -> Result<Self, SimError> {
        let look = |pose| {
            let seen = object.seen_from(camera, pose)?;
            progress();
            Ok::<_, Error>(seen)
        };
        let seen: Vec<FixedBitSet> = views.poses().par_iter().map(look).collect::<Result<_, _>>()?;
        let what =
            "no view candidate sees the object: is it beyond the camera's range, or are the views elsewhere?";
        Self::of_seen(seen).ok_or_else(|| SimError::format("views", what))
    }

    /// Uses the parts of the object that each view sees, in any unit, with the same number of parts for every
    /// view; `None` if no view sees any.
    pub fn of_seen(seen: Vec<FixedBitSet>) -> Option<Self> {
        let mut reachable = FixedBitSet::new();
        seen.iter().for_each(|seen| reachable.union_with(seen));
        (!reachable.is_clear()).then_some(Self { seen, reachable })
    }

    /// Returns the number of views.
    pub fn n_views(&self) -> usize {
        self.seen.len()
    }

    /// Returns the object voxels that a view sees.
    pub fn seen(&self, view: usize) -> &FixedBitSet {
        &self.seen[view]
    }

    /// Returns the object voxels that any candidate sees, by number.
    pub fn reachable(&self) -> &FixedBitSet {
        &self.reachable
    }

    /// Returns the number of object voxels that any candidate sees.
    pub fn n_reachable(&self) -> usize {
        self.reachable.count_ones(..)
    }

    /// Returns the share of the reachable object voxels seen after each of these views, 0..=1.
    pub fn coverage_curve(&self, views: &[usize]) -> Vec<f64> {
        let mut covered = FixedBitSet::with_capacity(self.reachable.len());
        let cover = |&view: &usize| {
            covered.union_with(&self.seen[view]);
            covered.count_ones(..) as f64 / self.n_reachable() as f64
        };
        views.iter().map(cover).collect()
    }
}
