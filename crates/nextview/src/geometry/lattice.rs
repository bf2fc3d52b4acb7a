use super::Aabb;
use crate::Error;
use crate::checked::checked_when_read;
use glam::{DVec3, IVec3, UVec3};
use serde::{Deserialize, Serialize};

/// Integer address of a voxel: it covers `key * voxel_size` up to `(key + 1) * voxel_size` on each axis.
pub type VoxelKey = IVec3;

/// The regular division of space into cubes of one size, with a corner at the world's origin.
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
    /// The smallest voxel size, 0.1 mm: below every depth camera's accuracy, and 32-bit keys still span 400
    /// km.
    pub const MIN_VOXEL_SIZE: f64 = 1e-4;

    /// A lattice of cubes with edges of `voxel_size` metres, which must be at least
    /// [`MIN_VOXEL_SIZE`](Self::MIN_VOXEL_SIZE) and finite.
    pub fn new(voxel_size: f64) -> Result<Self, Error> {
        let lattice = Self { voxel_size };
        lattice.check()?;
        Ok(lattice)
    }

    fn check(&self) -> Result<(), Error> {
        let voxel_size = self.voxel_size;
        if voxel_size >= Self::MIN_VOXEL_SIZE && voxel_size.is_finite() {
            return Ok(());
        }
        Err(Error::invalid("voxel_size_m", voxel_size, "a finite length of at least 0.0001 m"))
    }

    /// Edge of a voxel in metres.
    pub fn voxel_size(&self) -> f64 {
        self.voxel_size
    }

    /// A position in units of voxels; its floor is the key.
    pub fn to_voxels(&self, point: DVec3) -> DVec3 {
        point * (1.0 / self.voxel_size)
    }

    /// The voxel that contains the point; the lower face belongs to the voxel.
    pub fn key(&self, point: DVec3) -> VoxelKey {
        self.to_voxels(point).floor().as_ivec3()
    }

    /// The middle of a voxel.
    pub fn center(&self, key: VoxelKey) -> DVec3 {
        (key.as_dvec3() + 0.5) * self.voxel_size
    }

    /// The space that a block of voxels fills.
    pub fn bounds(&self, block: &VoxelBlock) -> Aabb {
        let (min, max) = (block.min().as_dvec3(), (block.max() + 1).as_dvec3());
        Aabb { min: min * self.voxel_size, max: max * self.voxel_size }
    }

    /// The block of voxels whose centres lie in the box (within 1e-6 of a voxel); none if there are none.
    pub fn block_inside(&self, aabb: &Aabb) -> Option<VoxelBlock> {
        let low = (self.to_voxels(aabb.min) - 0.5 - 1e-6).ceil().as_ivec3();
        let high = (self.to_voxels(aabb.max) - 0.5 + 1e-6).floor().as_ivec3();
        VoxelBlock::new(low, (high - low + 1).max(IVec3::ZERO).as_uvec3())
    }
}

/// A box of voxels, numbered with x varying fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelBlock {
    min: VoxelKey,
    dims: UVec3,
}

impl VoxelBlock {
    /// The block of `dims` voxels from `min` on; none if it is empty.
    pub fn new(min: VoxelKey, dims: UVec3) -> Option<Self> {
        (dims.min_element() > 0).then_some(Self { min, dims })
    }

    /// The voxel with the lowest coordinates.
    pub fn min(&self) -> VoxelKey {
        self.min
    }

    /// The voxel with the highest coordinates.
    pub fn max(&self) -> VoxelKey {
        self.min + self.dims.as_ivec3() - 1
    }

    /// Number of voxels along x, y and z; all positive.
    pub fn dims(&self) -> UVec3 {
        self.dims
    }

    /// Number of voxels.
    pub fn n_voxels(&self) -> usize {
        self.dims.x as usize * self.dims.y as usize * self.dims.z as usize
    }

    /// How far the index moves per step along x, y and z.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.dims.x as usize, self.dims.x as usize * self.dims.y as usize]
    }

    /// The index of a voxel; none if it lies outside.
    pub fn index(&self, key: VoxelKey) -> Option<usize> {
        let local = key - self.min;
        let inside = local.cmpge(IVec3::ZERO).all() && local.cmplt(self.dims.as_ivec3()).all();
        inside.then(|| self.index_of_local(local))
    }

    /// The voxel with this index, which must be below [`n_voxels`](Self::n_voxels).
    pub fn key(&self, index: usize) -> VoxelKey {
        let [_, row, slice] = self.strides();
        self.min + IVec3::new((index % row) as i32, (index % slice / row) as i32, (index / slice) as i32)
    }

    /// The indices of the voxels that touch this one by a face, an edge or a corner (26 inside the block,
    /// fewer at its border), in increasing order.
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
    fn refuses_sizes_that_are_no_length() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
            assert!(Lattice::new(size).is_err());
        }
    }
}
