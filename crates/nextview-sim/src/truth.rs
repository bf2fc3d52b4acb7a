//! The true object, and the part of it that each view candidate would truly see.

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

/// The voxels of the true surface: those that hold at least one point of it, exactly.
///
/// A surface that lies in the face between two voxels is in the voxel that [`Lattice::key`] assigns its
/// points to. Half of the measured points of such a surface are in the other voxel, only because the depths
/// of images are rounded; a map with that voxel is not wrong. So voxels within a micrometre of the surface
/// are kept apart: they are neither object voxels nor false. (The paper takes the voxels of many random
/// points of the surface. However dense these are, they miss voxels of which the surface cuts off a corner; a
/// camera finds them, and they count as false.)
#[derive(Clone, Debug)]
pub struct ObjectVoxels {
    lattice: Lattice,
    block: VoxelBlock,
    /// For each voxel of the block its number among the object voxels, `TOUCHED` or `NO_OBJECT`.
    number: Vec<u32>,
    n_voxels: usize,
}

const NO_OBJECT: u32 = u32::MAX;
const TOUCHED: u32 = NO_OBJECT - 1;

/// Rounding of points measured within a camera's range of 10 m, metres: depths have 24 bits.
const ROUNDING: f64 = 1e-6;

impl ObjectVoxels {
    /// The object voxels of a mesh within the block.
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

    /// How many there are.
    pub fn len(&self) -> usize {
        self.n_voxels
    }

    /// The block they are in.
    pub fn block(&self) -> VoxelBlock {
        self.block
    }

    /// Whether the block holds none.
    pub fn is_empty(&self) -> bool {
        self.n_voxels == 0
    }

    /// The number of an object voxel among them; none for other voxels.
    pub fn number(&self, voxel: VoxelKey) -> Option<usize> {
        let number = self.number[self.block.index(voxel)?];
        (number < TOUCHED).then_some(number as usize)
    }

    /// Whether a voxel of the block is false where it is occupied: no object voxel, and not as near to the
    /// surface as measured points are rounded. Voxels beyond the block are not false.
    pub fn is_false(&self, voxel: VoxelKey) -> bool {
        self.block.index(voxel).is_some_and(|index| self.number[index] == NO_OBJECT)
    }

    /// Which object voxels hold a measured point of the frame.
    pub fn seen_in(&self, frame: &Frame) -> FixedBitSet {
        self.hit_by(frame.points_in(self.lattice.bounds(&self.block)))
    }

    /// The same for the truth of the frame that the camera would take from a pose, in less time.
    pub fn seen_from(&self, camera: &SimulatedCamera, pose: &Pose) -> Result<FixedBitSet, Error> {
        Ok(self.seen_by(&camera.look(pose)?))
    }

    /// The same for a look that was taken.
    pub fn seen_by(&self, look: &Look<'_>) -> FixedBitSet {
        self.hit_by(look.points_in(self.lattice.bounds(&self.block)))
    }

    /// How a map compares with the object, and with the reachable ones of the object's voxels if they are
    /// known; the snapshot must be of the same block.
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
    /// Object voxels.
    pub n_object: usize,
    /// Occupied voxels that are object voxels.
    pub n_true: usize,
    /// Occupied voxels that are [false](ObjectVoxels::is_false).
    pub n_false: usize,
    /// Of the object voxels that any view candidate sees, the number of occupied ones and that of all; none
    /// where they are not known.
    pub reachable: Option<(usize, usize)>,
}

impl VoxelScore {
    /// The paper's voxel coverage, 0..=1, counting true voxels only: the recall over the whole object.
    pub fn coverage(&self) -> f64 {
        self.n_true as f64 / self.n_object as f64
    }

    /// Share, 0..=1, of the occupied voxels that are object voxels, but for those that are neither; none
    /// without occupied voxels.
    pub fn precision(&self) -> Option<f64> {
        share(self.n_true, self.n_true + self.n_false)
    }

    /// Share, 0..=1, of the reachable object voxels that are occupied; none where they are not known.
    pub fn recall(&self) -> Option<f64> {
        let (n_reached, n_reachable) = self.reachable?;
        share(n_reached, n_reachable)
    }

    /// Intersection over union, 0..=1, of the occupied and the reachable object voxels; none where those are
    /// not known. Occupied object voxels that no candidate sees are in neither: they are right, but nobody
    /// misses them.
    pub fn iou(&self) -> Option<f64> {
        let (n_reached, n_reachable) = self.reachable?;
        share(n_reached, n_reachable + self.n_false)
    }
}

fn share(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// The object voxels that every view candidate truly sees: only the clairvoyant planner knows them. A camera
/// with noise loses the same pixels here as when it takes its frame.
#[derive(Clone, Debug)]
pub struct TrueVisibility {
    /// Object voxels that each view sees.
    seen: Vec<FixedBitSet>,
    /// Object voxels that any view sees.
    reachable: FixedBitSet,
}

impl TrueVisibility {
    /// Takes an image of the object from every candidate. `progress` is called after each view, from several
    /// threads.
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

    /// From the parts of the object that each view sees, in any unit, with the same number of parts for every
    /// view; none if no view sees any.
    pub fn of_seen(seen: Vec<FixedBitSet>) -> Option<Self> {
        let mut reachable = FixedBitSet::new();
        seen.iter().for_each(|seen| reachable.union_with(seen));
        (!reachable.is_clear()).then_some(Self { seen, reachable })
    }

    /// Number of views.
    pub fn n_views(&self) -> usize {
        self.seen.len()
    }

    /// The object voxels that a view sees.
    pub fn seen(&self, view: usize) -> &FixedBitSet {
        &self.seen[view]
    }

    /// The object voxels that any candidate sees, by number.
    pub fn reachable(&self) -> &FixedBitSet {
        &self.reachable
    }

    /// Number of object voxels that any candidate sees.
    pub fn n_reachable(&self) -> usize {
        self.reachable.count_ones(..)
    }

    /// Share of the reachable object voxels seen after each of these views, 0..=1.
    pub fn coverage_curve(&self, views: &[usize]) -> Vec<f64> {
        let mut covered = FixedBitSet::with_capacity(self.reachable.len());
        let cover = |&view: &usize| {
            covered.union_with(&self.seen[view]);
            covered.count_ones(..) as f64 / self.n_reachable() as f64
        };
        views.iter().map(cover).collect()
    }
}
