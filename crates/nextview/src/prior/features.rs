use crate::geometry::{BoxCount, Nearest, NearestSource, VoxelBlock, VoxelKey};
use crate::map::{Occupancy, Snapshot};
use crate::{Cancel, Cancelled};
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Half-sides, in voxels, of the cubes in which measured voxels are counted.
const RADII: [i32; 5] = [1, 2, 4, 8, 16];

/// Voxels processed between two checks for cancellation.
const CHUNK: usize = 512;

/// Maximum distance that counts, voxels.
const FARTHEST: f32 = 40.0;

/// The known surroundings of each voxel that may hold an unseen piece of surface: the unknown voxels, and the
/// free ones that touch an unknown or an occupied voxel.
///
/// Free voxels are included because a voxel is free as soon as a ray passes it, and many that a first view
/// grazes still hold surface.
#[derive(Clone, Debug)]
pub struct VoxelFeatures {
    /// Indices into the snapshot, increasing.
    pub voxels: Vec<u32>,
    /// The features of each of these voxels; `docs/methods/most-surface.md` lists them.
    pub rows: Vec<[f32; VoxelFeatures::N]>,
    /// The direction of free space around each voxel: the gradient of free voxels, of length 1, or 0 if there
    /// is none.
    pub normals: Vec<Vec3>,
}

impl VoxelFeatures {
    /// Number of features of a voxel.
    pub const N: usize = 40;

    /// Computes the features of the snapshot's voxels.
    ///
    /// Distances are in voxels, and in logarithms where that helps learning. Nothing depends on the position
    /// of the world's origin, or changes when the world is turned by a quarter about its z axis. Only the
    /// voxel from which a surface is continued may differ then, if several are equally near.
    ///
    /// Fails if `cancel` is set.
    pub fn new(snapshot: &Snapshot, cancel: &Cancel) -> Result<Self, Cancelled> {
        let surroundings = FeatureInput::new(snapshot);
        cancel.check()?;
        let (block, occupancy) = (snapshot.block(), snapshot.occupancy());
        let voxels: Vec<u32> = (0..block.n_voxels())
            .filter(|&v| surroundings.may_hold_surface(occupancy, v))
            .map(|v| v as u32)
            .collect();
        let mut described = vec![([0.0; Self::N], Vec3::ZERO); voxels.len()];
        let parts = described.par_chunks_mut(CHUNK).zip(voxels.par_chunks(CHUNK));
        parts.try_for_each(|(described, voxels)| {
            cancel.check()?;
            let all = voxels.iter().map(|&voxel| surroundings.describe(snapshot, voxel as usize));
            described.iter_mut().zip(all).for_each(|(place, row)| *place = row);
            Ok(())
        })?;
        let (rows, normals) = described.into_iter().unzip();
        Ok(Self { voxels, rows, normals })
    }
}

/// The data from which the features are computed.
struct FeatureInput {
    block: VoxelBlock,
    occupied: NearestSource,
    free: NearestSource,
    unknown: NearestSource,
    n_occupied: BoxCount,
    n_free: BoxCount,
    /// Around the occupied voxels, or all if there are none.
    known: FeatureBox,
    /// Around the whole block.
    whole: FeatureBox,
}

/// A box, in voxels.
struct FeatureBox {
    center: Vec3,
    half: Vec3,
}

impl FeatureBox {
    fn new(low: IVec3, high: IVec3) -> Self {
        Self { center: (low + high).as_vec3() * 0.5, half: (high - low).as_vec3() * 0.5 + 1.0 }
    }
}

impl FeatureInput {
    fn new(snapshot: &Snapshot) -> Self {
        // Positions are computed in single precision.
        let (block, occupancy) = (snapshot.block().localized(), snapshot.occupancy());
        let is = |state: Occupancy| move |voxel: usize| occupancy[voxel] == state;
        let distances = |state: Occupancy| NearestSource::new(&block, is(state));
        let ((occupied, free), (unknown, n_occupied)) = rayon::join(
            || rayon::join(|| distances(Occupancy::Occupied), || distances(Occupancy::Free)),
            || {
                let count = || BoxCount::new(block, false, is(Occupancy::Occupied));
                rayon::join(|| distances(Occupancy::Unknown), count)
            },
        );
        let n_free = BoxCount::new(block, true, is(Occupancy::Free));
        let whole = FeatureBox::new(block.min(), block.max());
        let known = extent_of(block, is(Occupancy::Occupied));
        let known = known.unwrap_or(FeatureBox { center: whole.center, half: whole.half });
        Self { block, occupied, free, unknown, n_occupied, n_free, known, whole }
    }

    fn may_hold_surface(&self, occupancy: &[Occupancy], voxel: usize) -> bool {
        let touches = |source: &NearestSource| source.of(voxel).squared <= 3;
        match occupancy[voxel] {
            Occupancy::Occupied => false,
            Occupancy::Unknown => true,
            Occupancy::Free => touches(&self.unknown) || touches(&self.occupied),
        }
    }

    fn describe(&self, snapshot: &Snapshot, voxel: usize) -> ([f32; VoxelFeatures::N], Vec3) {
        let key = self.block.key(voxel);
        let is_free = snapshot.occupancy()[voxel] == Occupancy::Free;
        let (to_occupied, to_free) = (distance(&self.occupied, voxel), distance(&self.free, voxel));
        let mut row = FeatureRow::default();
        row.push([log(to_occupied), log(to_free)]);
        row.push(if is_free {
            [1.0, distance(&self.unknown, voxel).min(4.0), snapshot.probability()[voxel]]
        } else {
            [0.0, 0.0, 0.5]
        });
        self.shares(key, &mut row);
        self.place(key, to_occupied, to_free, &mut row);
        self.continuation(key, voxel, &mut row);
        (row.values, self.n_free.gradient(key, RADII[1]).normalize_or_zero())
    }

    /// The occupied and free shares of the cubes around; surfaces grow with the square of the side. Space
    /// outside the block is free.
    fn shares(&self, key: VoxelKey, row: &mut FeatureRow) {
        for radius in RADII {
            let side = (2 * radius + 1) as f32;
            let occupied = self.n_occupied.around(key, radius) as f32 / (side * side);
            row.push([occupied.sqrt(), self.n_free.around(key, radius) as f32 / (side * side * side)]);
        }
    }

    /// Position of the voxel in the object and in the box, and the known state at its symmetric positions.
    fn place(&self, key: VoxelKey, to_occupied: f32, to_free: f32, row: &mut FeatureRow) {
        let FeatureBox { center, half } = &self.known;
        let (offset, radius) = (key.as_vec3() - center, half.length());
        let out = offset.truncate().length();
        row.push([offset.length() / radius, (offset / half).abs().max_element()]);
        row.push([offset.z / radius, out / radius, radius.ln()]);
        row.push(self.at(2.0 * center - key.as_vec3()));
        let FeatureBox { center, half } = &self.whole;
        let (offset, side) = (key.as_vec3() - center, half.max_element());
        row.push([offset.length() / side, offset.abs().max_element() / side, side.ln()]);
        row.push([to_occupied / side, to_free / side]);
        let mirrored = 2.0 * center - key.as_vec3();
        row.push(self.at(mirrored));
        row.push(self.at(mirrored.with_z(key.z as f32)));
    }

    /// Distances of a position from occupied and free voxels.
    fn at(&self, place: Vec3) -> [f32; 2] {
        let voxel = self.block.index(place.round().as_ivec3());
        let [occupied, free] = voxel
            .map_or([FARTHEST, 0.0], |voxel| [distance(&self.occupied, voxel), distance(&self.free, voxel)]);
        [log(occupied), log(free)]
    }

    /// The position of the voxel relative to the nearest surface, along its normal and across, at two scales;
    /// and the relation of free and occupied space.
    fn continuation(&self, key: VoxelKey, voxel: usize, row: &mut FeatureRow) {
        let Nearest { squared, source } = self.occupied.of(voxel);
        let gradients = [(&self.n_free, RADII[2]), (&self.n_free, RADII[3]), (&self.n_occupied, RADII[3])]
            .map(|(counts, radius)| counts.gradient(key, radius));
        let slopes = [gradients[0].length() / 81.0, gradients[1].length() / 289.0];
        if squared == Nearest::NONE {
            row.push([0.0; 7]);
            return row.push(slopes);
        }
        let surface = self.block.key(source as usize);
        let offset = (key - surface).as_vec3();
        for radius in [RADII[1], RADII[2]] {
            let along = offset.dot(self.n_free.gradient(surface, radius).normalize_or_zero());
            let across = (squared as f32 - along * along).max(0.0).sqrt();
            row.push([along.signum() * log(along.abs()), log(across)]);
        }
        let away = offset.normalize_or_zero();
        row.push(gradients.map(|gradient| gradient.normalize_or_zero().dot(away)));
        row.push(slopes);
    }
}

/// Features as they are collected.
struct FeatureRow {
    values: [f32; VoxelFeatures::N],
    len: usize,
}

impl Default for FeatureRow {
    fn default() -> Self {
        Self { values: [0.0; VoxelFeatures::N], len: 0 }
    }
}

impl FeatureRow {
    fn push<const N: usize>(&mut self, values: [f32; N]) {
        self.values[self.len..self.len + N].copy_from_slice(&values);
        self.len += N;
    }
}

fn extent_of(block: VoxelBlock, is_part: impl Fn(usize) -> bool) -> Option<FeatureBox> {
    let mut keys = (0..block.n_voxels()).filter(|&voxel| is_part(voxel)).map(|voxel| block.key(voxel));
    let first = keys.next()?;
    let (low, high) = keys.fold((first, first), |(low, high), key| (low.min(key), high.max(key)));
    Some(FeatureBox::new(low, high))
}

fn distance(source: &NearestSource, voxel: usize) -> f32 {
    (source.of(voxel).squared as f32).sqrt().min(FARTHEST)
}

fn log(distance: f32) -> f32 {
    (1.0 + distance).ln()
}
