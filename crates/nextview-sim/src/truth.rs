//! The true object, and the part of it that each view candidate would truly see.

use crate::SimError;
use crate::camera::SimulatedCamera;
use crate::mesh::{TriangleMesh, sample_surface};
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::Error;
use nextview::geometry::{Lattice, Pose, VoxelBlock, VoxelKey};
use nextview::map::{Occupancy, Snapshot};
use nextview::sensor::Frame;
use nextview::view::ViewSpace;
use rayon::prelude::*;

/// The seed of all samples of the true surface; fixed, so that the truth is the same in every scan.
pub(crate) const SEED: u64 = 0;

/// Surface samples per voxel face: enough that hardly any voxel that the surface crosses has none.
const SAMPLES_PER_FACE: f64 = 16.0;

/// Maximum number of samples, for voxels that are tiny beside the object.
const MAX_SAMPLES: f64 = 8e6;

/// The voxels of the true surface: those that hold at least one of many samples, uniform by area (as in the
/// paper).
#[derive(Clone, Debug)]
pub struct ObjectVoxels {
    lattice: Lattice,
    block: VoxelBlock,
    /// For each voxel of the block its number among the object voxels, or `NO_OBJECT`.
    number: Vec<u32>,
    n_voxels: usize,
}

const NO_OBJECT: u32 = u32::MAX;

impl ObjectVoxels {
    /// The object voxels of a mesh within the block.
    pub fn new(mesh: &TriangleMesh, lattice: Lattice, block: VoxelBlock) -> Self {
        let face = lattice.voxel_size() * lattice.voxel_size();
        let n_samples = (mesh.area() / face * SAMPLES_PER_FACE).clamp(20_000.0, MAX_SAMPLES) as usize;
        let mut number = vec![NO_OBJECT; block.n_voxels()];
        for point in sample_surface(mesh, n_samples, SEED) {
            if let Some(index) = block.index(lattice.key(point)) {
                number[index] = 0;
            }
        }
        let mut n_voxels = 0;
        for number in number.iter_mut().filter(|number| **number != NO_OBJECT) {
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
        (number != NO_OBJECT).then_some(number as usize)
    }

    /// Which object voxels hold a measured point of the frame.
    pub fn seen_in(&self, frame: &Frame) -> FixedBitSet {
        self.hit_by(frame.points_in(self.lattice.bounds(&self.block)))
    }

    /// The same for the truth of the frame that the camera would take from a pose, in less time.
    pub fn seen_from(&self, camera: &SimulatedCamera, pose: &Pose) -> Result<FixedBitSet, Error> {
        Ok(self.hit_by(camera.points_in(pose, self.lattice.bounds(&self.block))?))
    }

    /// How a map compares with the object; the snapshot must be of the same block.
    pub fn compare(&self, snapshot: &Snapshot) -> VoxelScore {
        assert_eq!(snapshot.block(), self.block, "map and truth must cover the same voxels");
        let mut score = VoxelScore { n_object: self.n_voxels, ..VoxelScore::default() };
        for (number, occupancy) in self.number.iter().zip(snapshot.occupancy()) {
            if *occupancy == Occupancy::Occupied {
                *(if *number == NO_OBJECT { &mut score.n_false } else { &mut score.n_true }) += 1;
            }
        }
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
    /// Occupied voxels that are not.
    pub n_false: usize,
}

impl VoxelScore {
    /// The paper's voxel coverage, 0..=1, counting true voxels only.
    pub fn coverage(&self) -> f64 {
        self.n_true as f64 / self.n_object as f64
    }
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
