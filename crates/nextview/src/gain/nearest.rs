use crate::geometry::VoxelBlock;
use crate::instructions::instructions;
use crate::{Cancel, Cancelled};
use rayon::prelude::*;

/// Maximum squared distance: larger ones are not distinguished.
pub(super) const FAR_SQ: u32 = 75_000;

/// Number of voxels, side by side along x, whose lists are processed at once: one vector of 512 bits.
const LANES: usize = 16;

/// For some voxels side by side along x, the squared distances to the K nearest points, ascending. Signed,
/// because plain x86-64 cannot compare unsigned vectors.
type DistanceLists<const K: usize> = [[i32; LANES]; K];

/// Returns the sum of the squared distances, in voxels, from every needed voxel of the block to the K nearest
/// of the given voxels, which must be in increasing order. Distances of at least [`FAR_SQ`], and missing
/// neighbours, count as [`FAR_SQ`]. Voxels that are not needed get the same sum or 0.
///
/// Exact and separable, like a distance transform (Felzenszwalb & Huttenlocher 2012): of the points in a row
/// along x, only the K nearest along x can be among the K nearest of any voxel of that row, and so on for y
/// and z. Each axis is one pass that merges the lists of a line, outward from the voxel until nothing can be
/// nearer. All passes run for a few x before the next: the lists of the whole block would take 375 MB at 250
/// voxels a side.
pub(super) fn sums_of_nearest<const K: usize>(
    block: &VoxelBlock,
    points: &[usize],
    is_needed: impl Fn(usize) -> bool + Sync,
    cancel: &Cancel,
) -> Result<Vec<u32>, Cancelled> {
    let [n_x, n_y, n_z] = block.dims().to_array().map(|n| n as usize);
    let rows: Vec<&[usize]> = points.chunk_by(|a, b| a / n_x == b / n_x).collect();
    let slab = |x: usize| Slab::<K> { x, n_x, n_y, n_z, rows: &rows };
    let starts: Vec<usize> = (0..n_x).step_by(LANES).collect();
    let sums_from = |x: usize| {
        let slab = slab(x);
        // A closure that consumes its captures: any other is called through a function without vector
        // instructions.
        instructions().dispatch(
            #[inline(always)]
            || slab.sums(&is_needed, cancel),
        )
    };
    let slabs: Vec<Vec<u32>> = starts.into_par_iter().map(sums_from).collect::<Result<_, Cancelled>>()?;
    let mut sums = vec![0; block.n_voxels()];
    sums.par_chunks_mut(n_x).enumerate().for_each(|(row, sums)| {
        for (sums, slab) in sums.chunks_mut(LANES).zip(&slabs) {
            sums.copy_from_slice(&slab[row * LANES..][..sums.len()]);
        }
    });
    Ok(sums)
}

/// The voxels of [`LANES`] neighbouring x; the last ones may lie outside the block.
struct Slab<'a, const K: usize> {
    x: usize,
    n_x: usize,
    n_y: usize,
    n_z: usize,
    /// The points of each non-empty row along x, by index in the block.
    rows: &'a [&'a [usize]],
}

impl<const K: usize> Slab<'_, K> {
    const NOTHING: DistanceLists<K> = [[FAR_SQ as i32; LANES]; K];

    /// The sums of all voxels of the slab, x varying fastest.
    #[inline(always)]
    fn sums(self, is_needed: &impl Fn(usize) -> bool, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
        let plane_of = |row: &[usize]| row[0] / (self.n_x * self.n_y);
        let planes: Vec<&[&[usize]]> = self.rows.chunk_by(|a, b| plane_of(a) == plane_of(b)).collect();
        let z: Vec<usize> = planes.iter().map(|rows| plane_of(rows[0])).collect();
        let mut in_plane: Vec<DistanceLists<K>> = Vec::with_capacity(planes.len() * self.n_y);
        for rows in planes {
            cancel.check()?;
            self.push_plane(rows, &mut in_plane);
        }
        let mut sums = vec![0; LANES * self.n_y * self.n_z];
        // A column of lists along z stays in the cache.
        for y in 0..self.n_y {
            cancel.check()?;
            let mut nearest = Self::NOTHING;
            for at in 0..self.n_z {
                let row = y + at * self.n_y;
                if !self.is_any_needed(row, is_needed) {
                    nearest = Self::NOTHING;
                    continue;
                }
                nearest = next_lists(&nearest);
                merge_line(&mut nearest, &z, &in_plane[y.min(in_plane.len())..], self.n_y, at);
                let sums = &mut sums[row * LANES..][..LANES];
                nearest.iter().for_each(|of| sums.iter_mut().zip(of).for_each(|(sum, d)| *sum += *d as u32));
            }
        }
        Ok(sums)
    }

    /// Appends the lists of all rows of a plane, from the points of that plane alone.
    #[inline(always)]
    fn push_plane(&self, rows: &[&[usize]], in_plane: &mut Vec<DistanceLists<K>>) {
        let y: Vec<usize> = rows.iter().map(|row| row[0] / self.n_x % self.n_y).collect();
        let in_row: Vec<DistanceLists<K>> = rows.iter().map(|row| self.row(row)).collect();
        let mut nearest = Self::NOTHING;
        for at in 0..self.n_y {
            nearest = next_lists(&nearest);
            merge_line(&mut nearest, &y, &in_row, 1, at);
            in_plane.push(nearest);
        }
    }

    /// The lists of a row from its own points.
    #[inline(always)]
    fn row(&self, points: &[usize]) -> DistanceLists<K> {
        let mut nearest = Self::NOTHING;
        for point in points {
            let x = point % self.n_x;
            insert(&mut nearest, std::array::from_fn(|lane| square(x.abs_diff(self.x + lane))));
        }
        nearest
    }

    #[inline(always)]
    fn is_any_needed(&self, row: usize, is_needed: &impl Fn(usize) -> bool) -> bool {
        let n = LANES.min(self.n_x - self.x);
        (0..n).any(|lane| is_needed(row * self.n_x + self.x + lane))
    }
}

/// Merges lists along a line into those of the voxels at one place on it. The list of `places[i]`, which
/// increase, is `lists[i * stride]`.
#[inline(always)]
fn merge_line<const K: usize>(
    nearest: &mut DistanceLists<K>,
    places: &[usize],
    lists: &[DistanceLists<K>],
    stride: usize,
    at: usize,
) {
    let mut above = places.partition_point(|&place| place < at);
    let mut below = above;
    loop {
        let down = if below > 0 { at - places[below - 1] } else { usize::MAX };
        let up = if above < places.len() { places[above] - at } else { usize::MAX };
        let distance_sq = square(down.min(up));
        if !any_less(&[distance_sq; LANES], &nearest[K - 1]) {
            return;
        }
        if down < up {
            below -= 1;
            merge(nearest, &lists[below * stride], distance_sq);
        } else {
            merge(nearest, &lists[above * stride], distance_sq);
            above += 1;
        }
    }
}

/// The initial lists of a voxel, one step along a line from one of these lists. Its K nearest points are at
/// most as far as theirs plus the step, so nothing beyond is ever inserted.
#[inline(always)]
fn next_lists<const K: usize>(nearest: &DistanceLists<K>) -> DistanceLists<K> {
    let limit = nearest[K - 1].map(|d| (d + 2 + (2.0 * (d as f32).sqrt()) as i32 + 1).min(FAR_SQ as i32));
    [limit; K]
}

/// Inserts the distances of `other`, moved away by `offset`, into the ascending lists.
#[inline(always)]
fn merge<const K: usize>(nearest: &mut DistanceLists<K>, other: &DistanceLists<K>, offset: i32) {
    for distance_sq in other {
        let distance_sq = std::array::from_fn(|lane| distance_sq[lane] + offset);
        if !any_less(&distance_sq, &nearest[K - 1]) {
            return;
        }
        insert(nearest, distance_sq);
    }
}

/// Inserts a distance into each ascending list and drops the largest.
#[inline(always)]
fn insert<const K: usize>(nearest: &mut DistanceLists<K>, mut distance_sq: [i32; LANES]) {
    for of in nearest {
        for lane in 0..LANES {
            let (a, b) = (of[lane], distance_sq[lane]);
            (of[lane], distance_sq[lane]) = (a.min(b), a.max(b));
        }
    }
}

/// The square of a distance, at most [`FAR_SQ`].
#[inline(always)]
fn square(distance: usize) -> i32 {
    (distance.min(FAR_SQ as usize) as u64).pow(2).min(FAR_SQ.into()) as i32
}

#[inline(always)]
fn any_less(a: &[i32; LANES], b: &[i32; LANES]) -> bool {
    // All lanes are compared: stopping at the first would be a branch for each.
    (0..LANES).fold(false, |any, lane| any | (a[lane] < b[lane]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    /// The slow twin: every distance, sorted.
    fn by_sorting(block: &VoxelBlock, points: &[usize], index: usize, k: usize) -> u32 {
        let to = |&p: &usize| (block.key(index) - block.key(p)).length_squared() as u32;
        let mut all: Vec<u32> = points.iter().map(to).chain(vec![FAR_SQ; k]).map(|d| d.min(FAR_SQ)).collect();
        all.sort_unstable();
        all[..k].iter().sum()
    }

    fn check<const K: usize>(block: &VoxelBlock, points: &[usize]) -> Result<(), TestCaseError> {
        let is_needed = |index: usize| index % 5 != 2;
        let sums = sums_of_nearest::<K>(block, points, is_needed, &Cancel::default()).unwrap();
        prop_assert_eq!(sums.len(), block.n_voxels());
        for index in (0..block.n_voxels()).filter(|&index| is_needed(index)) {
            prop_assert_eq!(sums[index], by_sorting(block, points, index, K));
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn equals_sorting_all_distances(
            dims in prop::array::uniform3(1_u32..9), long in 0_usize..3, picks in prop::collection::vec(any::<prop::sample::Index>(), 0..30),
        ) {
            // One axis longer than a slab is wide, or than the distances that are distinguished.
                        let dims = UVec3::from_array(std::array::from_fn(|axis| dims[axis] * [40, 1, 1][(axis + long) % 3]));
            let block = VoxelBlock::new(IVec3::new(-3, 0, 5), dims).unwrap();
            let mut points: Vec<usize> = picks.iter().map(|pick| pick.index(block.n_voxels())).collect();
            points.sort_unstable();
            points.dedup();
            check::<6>(&block, &points)?;
            check::<1>(&block, &points)?;
        }
    }
}
