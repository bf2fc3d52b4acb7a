use super::Aabb;
use crate::Error;
use crate::checked::checked_when_read;
use glam::{DVec3, IVec3, UVec3};
use serde::{Deserialize, Serialize};

/// Integer address of a voxel: it covers `key * voxel_size` to `(key + 1) * voxel_size` on each axis.
pub type VoxelKey = IVec3;

/// The regular division of space into cubic voxels, with a corner at the world's origin.
///
/// ```
/// use glam::{DVec3, IVec3};
/// use nextview::geometry::Lattice;
///
/// let lattice = Lattice::new(0.01).unwrap();
/// assert_eq!(lattice.key(DVec3::new(0.005, 0.0, -0.001)), IVec3::new(0, 0, -1));
/// assert!(lattice.center(IVec3::new(0, 0, -1)).distance(DVec3::new(0.005, 0.005, -0.005)) < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct Lattice {
    #[serde(rename = "voxel_size_m")]
    voxel_size: f64,
}

checked_when_read!(Lattice);

impl Lattice {
    /// The smallest voxel size, 0.1 mm: finer than the accuracy of any depth camera, and 32-bit keys still
    /// span 400 km.
    pub const MIN_VOXEL_SIZE: f64 = 1e-4;

    /// Largest distance of a mapped voxel from the origin, voxels along each axis: 268 km in voxels of 1 mm.
    /// Keys in voxels a quarter as large, such as those of the final mesh, still fit 32 bits.
    pub const REACH: i32 = 1 << 28;

    /// Returns the lattice of voxels with edges of `voxel_size` metres, at least
    /// [`MIN_VOXEL_SIZE`](Self::MIN_VOXEL_SIZE) and at most 1e12.
    pub fn new(voxel_size: f64) -> Result<Self, Error> {
        let lattice = Self { voxel_size };
        lattice.check()?;
        Ok(lattice)
    }

    fn check(&self) -> Result<(), Error> {
        let voxel_size = self.voxel_size;
        if (Self::MIN_VOXEL_SIZE..=1e12).contains(&voxel_size) {
            return Ok(());
        }
        Err(Error::invalid("voxel_size_m", voxel_size, "a finite length of at least 0.0001 m"))
    }

    /// Returns the lattice of voxels twice as large.
    pub(crate) fn doubled(&self) -> Self {
        Self { voxel_size: 2.0 * self.voxel_size }
    }

    /// Returns the edge of a voxel in metres.
    pub fn voxel_size(&self) -> f64 {
        self.voxel_size
    }

    /// Converts a position to units of voxels; its floor is the key.
    pub fn to_voxels(&self, point: DVec3) -> DVec3 {
        point * (1.0 / self.voxel_size)
    }

    /// Returns the voxel that contains the point; lower faces belong to the voxel.
    pub fn key(&self, point: DVec3) -> VoxelKey {
        self.to_voxels(point).floor().as_ivec3()
    }

    /// Returns the centre of a voxel.
    pub fn center(&self, key: VoxelKey) -> DVec3 {
        (key.as_dvec3() + 0.5) * self.voxel_size
    }

    /// Returns the box filled by a block of voxels.
    pub fn bounds(&self, block: &VoxelBlock) -> Aabb {
        let (min, max) = (block.min().as_dvec3(), (block.max() + 1).as_dvec3());
        Aabb { min: min * self.voxel_size, max: max * self.voxel_size }
    }

    /// Returns the lowest and the highest voxel whose centres lie in the box (within 1e-6 of a voxel); `None`
    /// if there are none, or if they are beyond [`REACH`](Self::REACH).
    pub fn keys_inside(&self, aabb: &Aabb) -> Option<(VoxelKey, VoxelKey)> {
        let low = (self.to_voxels(aabb.min) - 0.5 - 1e-6).ceil();
        let high = (self.to_voxels(aabb.max) - 0.5 + 1e-6).floor();
        let reach = DVec3::splat(Self::REACH as f64);
        let is_there = low.cmple(high) & low.cmpge(-reach) & high.cmple(reach);
        is_there.all().then(|| (low.as_ivec3(), high.as_ivec3()))
    }

    /// Returns the block of voxels whose centres lie in the box (within 1e-6 of a voxel); `None` if there are
    /// none, or too many or too far away for a [block](VoxelBlock::new).
    pub fn block_inside(&self, aabb: &Aabb) -> Option<VoxelBlock> {
        let (low, high) = self.keys_inside(aabb)?;
        VoxelBlock::new(low, (high - low + 1).as_uvec3())
    }
}

/// Returns a voxel that is, along each axis, at most 32,768 voxels from all those between two, both included,
/// if they span 65,536 or less: the lattice's origin if possible, otherwise the voxel in their middle.
///
/// Relative to it, keys fit the 16 bits of an OctoMap and are exact in single precision.
pub fn local_origin(min: VoxelKey, max: VoxelKey) -> VoxelKey {
    let fits = min.cmpge(IVec3::splat(-(1 << 15))).all() && max.cmplt(IVec3::splat(1 << 15)).all();
    if fits { IVec3::ZERO } else { min + (max - min + 1) / 2 }
}

/// A box of voxels, numbered with x varying fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelBlock {
    min: VoxelKey,
    dims: UVec3,
}

impl VoxelBlock {
    /// Maximum number of voxels of a block: its indices, and those of a layer around it, fit 32 bits.
    pub const MOST_VOXELS: usize = 1 << 29;

    /// Maximum number of voxels along an axis, as in an OctoMap.
    const MOST_ALONG: u32 = 1 << 16;

    /// Returns the block of `dims` voxels from `min` on; `None` if it is empty, has more than 65,536 voxels
    /// along an axis or more than [`MOST_VOXELS`](Self::MOST_VOXELS), or begins beyond 2^30 voxels from the
    /// origin.
    pub fn new(min: VoxelKey, dims: UVec3) -> Option<Self> {
        let is_near = min.cmpge(IVec3::splat(-(1 << 30))).all() && min.cmple(IVec3::splat(1 << 30)).all();
        let is_small = dims.min_element() > 0 && dims.max_element() <= Self::MOST_ALONG;
        let block = Self { min, dims };
        (is_near && is_small && block.n_voxels() <= Self::MOST_VOXELS).then_some(block)
    }

    /// Returns a voxel near the block, relative to which its coordinates are exact in single precision.
    pub(crate) fn local_origin(&self) -> VoxelKey {
        local_origin(self.min, self.max())
    }

    /// Returns the block with its keys relative to the local origin.
    pub(crate) fn localized(&self) -> Self {
        Self { min: self.min - self.local_origin(), ..*self }
    }

    /// Returns the block with a layer of voxels around it.
    pub(crate) fn padded(&self) -> Self {
        Self { min: self.min - 1, dims: self.dims + 2 }
    }

    /// Returns the voxel with the lowest coordinates.
    pub fn min(&self) -> VoxelKey {
        self.min
    }

    /// Returns the voxel with the highest coordinates.
    pub fn max(&self) -> VoxelKey {
        self.min + self.dims.as_ivec3() - 1
    }

    /// Returns the number of voxels along x, y and z; all positive.
    pub fn dims(&self) -> UVec3 {
        self.dims
    }

    /// Returns the number of voxels.
    pub fn n_voxels(&self) -> usize {
        self.dims.x as usize * self.dims.y as usize * self.dims.z as usize
    }

    /// Returns the index strides along x, y and z.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.dims.x as usize, self.dims.x as usize * self.dims.y as usize]
    }

    /// Returns the index of a voxel; `None` if it lies outside.
    pub fn index(&self, key: VoxelKey) -> Option<usize> {
        // A difference that overflows wraps to one that is also outside.
        let local = key.wrapping_sub(self.min);
        let inside = local.cmpge(IVec3::ZERO).all() && local.cmplt(self.dims.as_ivec3()).all();
        inside.then(|| self.index_of_local(local))
    }

    /// Returns the voxel with this index, which must be below [`n_voxels`](Self::n_voxels).
    pub fn key(&self, index: usize) -> VoxelKey {
        let [_, row, slice] = self.strides();
        self.min + IVec3::new((index % row) as i32, (index % slice / row) as i32, (index / slice) as i32)
    }

    /// Returns the indices of the voxels that share a face, edge or corner with this one (26 inside the
    /// block, fewer at its border), in increasing order.
    pub fn neighbors(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let block = *self;
        let local = block.key(index) - block.min;
        let low = (local - 1).max(IVec3::ZERO);
        let high = (local + 1).min(block.dims.as_ivec3() - 1);
        (low.z..=high.z).flat_map(move |z| {
            (low.y..=high.y).flat_map(move |y| {
                (low.x..=high.x)
                    .map(move |x| block.index_of_local(IVec3::new(x, y, z)))
                    .filter(move |&i| i != index)
            })
        })
    }

    fn index_of_local(&self, local: IVec3) -> usize {
        let [_, row, slice] = self.strides();
        local.x as usize + local.y as usize * row + local.z as usize * slice
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_indices_are_inverses() {
        let block = VoxelBlock::new(IVec3::new(-2, 3, -7), UVec3::new(3, 4, 5)).unwrap();
        assert_eq!(block.n_voxels(), 60);
        for i in 0..60 {
            assert_eq!(block.index(block.key(i)), Some(i));
        }
        assert_eq!(block.index(IVec3::new(1, 3, -7)), None);
        assert_eq!(block.index(IVec3::new(-3, 3, -7)), None);
    }

    #[test]
    fn neighbors_are_all_cells_at_chebyshev_distance_one() {
        let block = VoxelBlock::new(IVec3::splat(-1), UVec3::new(3, 4, 5)).unwrap();
        for i in 0..block.n_voxels() {
            let expected: Vec<usize> = (0..block.n_voxels())
                .filter(|&j| j != i && (block.key(i) - block.key(j)).abs().max_element() == 1)
                .collect();
            assert_eq!(block.neighbors(i).collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn block_inside_takes_voxels_by_their_centre() {
        let lattice = Lattice::new(0.01).unwrap();
        let block = lattice.block_inside(&Aabb { min: DVec3::ZERO, max: DVec3::splat(0.024) }).unwrap();
        assert_eq!((block.min(), block.dims()), (IVec3::ZERO, UVec3::splat(2)));
        assert_eq!(lattice.block_inside(&Aabb { min: DVec3::ZERO, max: DVec3::splat(0.004) }), None);
    }

    #[test]
    fn local_keys_have_16_bits() {
        let block = |min: i32, n: u32| VoxelBlock::new(IVec3::new(min, -5, 7), UVec3::new(n, 9, 1)).unwrap();
        for near in [block(-32768, 1), block(32767, 1), block(-100, 32868)] {
            assert_eq!((near.local_origin(), near.localized()), (IVec3::ZERO, near));
        }
        for far in [block(-32769, 1), block(32760, 9), block(1 << 28, 1 << 16), block(-(1 << 28), 65535)] {
            let local = far.localized();
            assert!(local.min().min_element() >= -32768 && local.max().max_element() < 32768, "{local:?}");
            assert_eq!(local.min() + far.local_origin(), far.min());
        }
    }

    #[test]
    fn refuses_blocks_without_bounds() {
        let block = |min: i32, dims: u32| VoxelBlock::new(IVec3::splat(min), UVec3::splat(dims));
        assert!(block(0, 0).is_none() && block(0, 1 << 21).is_none() && block(0, 1 << 16).is_none());
        assert!(block(i32::MIN, 1).is_none() && block(i32::MAX, 1).is_none() && block(1 << 30, 1).is_some());
        assert!(VoxelBlock::new(IVec3::ZERO, UVec3::new(1 << 16, 1 << 13, 1)).is_some());
        assert!(VoxelBlock::new(IVec3::ZERO, UVec3::new((1 << 16) + 1, 1, 1)).is_none());
        let lattice = Lattice::new(0.01).unwrap();
        for half in [f64::NAN, f64::INFINITY, 1e300, 1e4] {
            assert_eq!(lattice.block_inside(&Aabb::cube(DVec3::ZERO, half)), None);
            assert_eq!(lattice.block_inside(&Aabb::cube(DVec3::X * half * 1e6, 0.1)), None);
        }
        let (low, high) = lattice.keys_inside(&Aabb::cube(DVec3::ZERO, 1e4)).unwrap();
        assert_eq!((low, high), (IVec3::splat(-1_000_000), IVec3::splat(999_999)));
    }

    #[test]
    fn refuses_sizes_that_are_no_length() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
            assert!(Lattice::new(size).is_err());
        }
    }
}
