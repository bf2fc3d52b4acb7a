use super::packet::OUTSIDE;
use super::pass_grid::PassGrid;
use crate::geometry::lanes::{FIRST_INDEX, LANES, abs, any, cell, floor, load, store};
use glam::DVec3;
use pulp::Simd;

/// How far each cell of a [`PassGrid`] is from everything that weakens or ends a ray.
///
/// Rays that start in clear space leap over it: a few look-ups in place of a step for every voxel.
#[derive(Debug)]
pub(super) struct ClearSpace {
    /// By cell, the largest distance along an axis to the nearest voxel that is not clear, up to
    /// [`FARTHEST`]; [`BEYOND`] in the layer around the block.
    room: Vec<u8>,
    /// The corner of cell 0, in voxels.
    corner: DVec3,
    /// The largest coordinates of a cell.
    last: DVec3,
    strides: DVec3,
}

/// Marks the cells outside the block.
const BEYOND: u8 = u8::MAX;
const FARTHEST: u8 = BEYOND - 1;

/// Rays leap from cells with more room than this: a shorter leap costs as much as its steps.
const LITTLE: u8 = 4;

/// How often a ray leaps: the later leaps are short.
const N_LEAPS: usize = 4;

/// Sides of a block, in voxels, from which on leaps save time.
const LONG: u32 = 32;

/// How far behind a border a leap ends, in depths of a voxel: far more than the rounding of a position.
const BEHIND_BORDER: f64 = 1e-6;

/// The walks of a packet along one axis.
#[derive(Clone, Copy)]
pub(super) struct Axis<S: Simd> {
    pub next: S::f64s,
    pub step: S::f64s,
    pub stride: S::f64s,
}

impl ClearSpace {
    /// None where leaps would save nothing.
    pub fn of(grid: &PassGrid) -> Option<Self> {
        if grid.block.dims().max_element() < LONG || !grid.passes.contains(&1.0) {
            return None;
        }
        let room = room(grid);
        let strides = DVec3::from_array(grid.padded.strides().map(|stride| stride as f64));
        let (corner, last) = (grid.padded.min().as_dvec3(), (grid.padded.dims() - 1).as_dvec3());
        room.iter().any(|&room| room > LITTLE && room != BEYOND).then_some(Self {
            room,
            corner,
            last,
            strides,
        })
    }

    /// Moves rays that are about to walk from the cells of `index` to a later cell of their walks, all before
    /// which are clear; rays that meet nothing else get the index [`OUTSIDE`].
    ///
    /// The walk crosses the borders of voxels in the order of their distances, which it finds by repeated
    /// addition. The same additions are made here, up to a distance, so that what is left of the walk is the
    /// same to the bit.
    #[inline(always)]
    pub fn leap<S: Simd>(
        &self,
        simd: S,
        origin: DVec3,
        directions: [S::f64s; 3],
        axes: &mut [Axis<S>; 3],
        index: S::f64s,
    ) -> S::f64s {
        let outside = simd.splat_f64s(OUTSIDE);
        let [x, y, z] = *axes;
        // The walk is in its first cell from the last border behind it on.
        let behind = simd.max_f64s(behind(simd, &x), simd.max_f64s(behind(simd, &y), behind(simd, &z)));
        let mut t = simd.add_f64s(behind, simd.splat_f64s(BEHIND_BORDER));
        let mut leaps = simd.less_than_f64s(outside, index);
        let mut is_past = simd.not_m64s(leaps);
        // Where a ray does not leap, `t` means nothing: it may lie behind a first cell that is hardly touched.
        let mut has_leapt = simd.less_than_f64s(outside, outside);
        let origin = origin - self.corner;
        for _ in 0..N_LEAPS {
            let places = [
                self.place(simd, 0, origin, directions, t),
                self.place(simd, 1, origin, directions, t),
                self.place(simd, 2, origin, directions, t),
            ];
            let room = self.rooms(simd, places);
            let is_beyond = simd.equal_f64s(room, simd.splat_f64s(BEYOND as f64));
            is_past = simd.or_m64s(is_past, simd.and_m64s(simd.and_m64s(leaps, has_leapt), is_beyond));
            let has_room = simd.less_than_f64s(simd.splat_f64s(LITTLE as f64), room);
            leaps = simd.and_m64s(leaps, simd.and_m64s(has_room, simd.not_m64s(is_beyond)));
            if !any(simd, leaps) {
                break;
            }
            // One clear cell stays around those that are leapt over, so that rounding cannot hide a voxel.
            let reach = simd.sub_f64s(room, simd.splat_f64s(2.0));
            let mut border = exit(simd, origin.x, places[0], reach, directions[0], &x);
            border = simd.min_f64s(border, exit(simd, origin.y, places[1], reach, directions[1], &y));
            border = simd.min_f64s(border, exit(simd, origin.z, places[2], reach, directions[2], &z));
            let behind = simd.add_f64s(border, simd.splat_f64s(BEHIND_BORDER));
            t = simd.select_f64s(leaps, behind, t);
            has_leapt = simd.or_m64s(has_leapt, leaps);
        }
        let walks = simd.and_m64s(has_leapt, simd.not_m64s(is_past));
        t = simd.select_f64s(walks, t, simd.splat_f64s(f64::NEG_INFINITY));
        let moved = cross_before(simd, axes, t);
        simd.select_f64s(is_past, outside, simd.add_f64s(index, moved))
    }

    /// The coordinate of the cell in which a ray is at `t`, up to the layer around the block.
    #[inline(always)]
    fn place<S: Simd>(
        &self,
        simd: S,
        axis: usize,
        origin: DVec3,
        directions: [S::f64s; 3],
        t: S::f64s,
    ) -> S::f64s {
        let at = simd.add_f64s(simd.splat_f64s(origin[axis]), simd.mul_f64s(directions[axis], t));
        let at = simd.min_f64s(simd.max_f64s(at, simd.splat_f64s(0.0)), simd.splat_f64s(self.last[axis]));
        floor(simd, at)
    }

    #[inline(always)]
    fn rooms<S: Simd>(&self, simd: S, [x, y, z]: [S::f64s; 3]) -> S::f64s {
        let mut index = simd.add_f64s(simd.splat_f64s(FIRST_INDEX), x);
        index = simd.add_f64s(index, simd.mul_f64s(y, simd.splat_f64s(self.strides.y)));
        index = simd.add_f64s(index, simd.mul_f64s(z, simd.splat_f64s(self.strides.z)));
        let mut lanes = [0.0; LANES];
        store::<S>(&mut lanes, 0, index);
        #[allow(
            clippy::needless_range_loop,
            reason = "iterators are not always inlined into vector instructions"
        )]
        for lane in 0..S::F64_LANES {
            lanes[lane] = self.room.get(cell(lanes[lane])).copied().unwrap_or(BEYOND) as f64;
        }
        load::<S>(&lanes, 0)
    }
}

/// The border behind a ray along an axis; minus infinity if there is none.
#[inline(always)]
fn behind<S: Simd>(simd: S, axis: &Axis<S>) -> S::f64s {
    let infinity = simd.splat_f64s(f64::INFINITY);
    let is_still = simd.equal_f64s(axis.next, infinity);
    simd.select_f64s(is_still, simd.splat_f64s(f64::NEG_INFINITY), simd.sub_f64s(axis.next, axis.step))
}

/// Where a ray leaves the cells along an axis that are up to `reach` from a place.
#[inline(always)]
fn exit<S: Simd>(
    simd: S,
    origin: f64,
    place: S::f64s,
    reach: S::f64s,
    direction: S::f64s,
    axis: &Axis<S>,
) -> S::f64s {
    let (zero, infinity) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
    let high = simd.add_f64s(simd.add_f64s(place, reach), simd.splat_f64s(1.0));
    let border = simd.select_f64s(simd.less_than_f64s(zero, direction), high, simd.sub_f64s(place, reach));
    let distance = abs(simd, simd.sub_f64s(border, simd.splat_f64s(origin)));
    simd.select_f64s(simd.equal_f64s(axis.next, infinity), infinity, simd.mul_f64s(distance, axis.step))
}

/// Crosses all borders before `t`, and returns how the indices move.
#[inline(always)]
fn cross_before<S: Simd>(simd: S, axes: &mut [Axis<S>; 3], t: S::f64s) -> S::f64s {
    let mut moved = [simd.splat_f64s(0.0); 3];
    loop {
        // Checking whether any lane continues costs as much as a step.
        for _ in 0..3 {
            cross_each(simd, axes, t, &mut moved);
        }
        let crosses = cross_each(simd, axes, t, &mut moved);
        if simd.first_true_m64s(crosses) == S::F64_LANES {
            return simd.add_f64s(moved[0], simd.add_f64s(moved[1], moved[2]));
        }
    }
}

/// Crosses the next border along each axis, if it is before `t`, and returns which rays crossed one.
#[inline(always)]
fn cross_each<S: Simd>(simd: S, axes: &mut [Axis<S>; 3], t: S::f64s, moved: &mut [S::f64s; 3]) -> S::m64s {
    let [x, y, z] = axes;
    let x = cross(simd, x, t, &mut moved[0]);
    let y = cross(simd, y, t, &mut moved[1]);
    let z = cross(simd, z, t, &mut moved[2]);
    simd.or_m64s(x, simd.or_m64s(y, z))
}

#[inline(always)]
fn cross<S: Simd>(simd: S, axis: &mut Axis<S>, t: S::f64s, moved: &mut S::f64s) -> S::m64s {
    let crosses = simd.less_than_f64s(axis.next, t);
    axis.next = simd.select_f64s(crosses, simd.add_f64s(axis.next, axis.step), axis.next);
    *moved = simd.select_f64s(crosses, simd.add_f64s(*moved, axis.stride), *moved);
    crosses
}

/// See [`ClearSpace::room`]: two passes over the cells, each of which looks at half of the neighbours
/// (Rosenfeld & Pfaltz 1966).
fn room(grid: &PassGrid) -> Vec<u8> {
    let [_, stride_y, stride_z] = grid.padded.strides();
    let n_x = grid.padded.dims().x as usize;
    let start = |&pass: &f32| if pass == 1.0 || pass == PassGrid::OUTSIDE { FARTHEST } else { 0 };
    let mut room: Vec<u8> = grid.passes.iter().map(start).collect();
    let before = [stride_y, stride_z - stride_y, stride_z, stride_z + stride_y];
    let mut nearest = vec![FARTHEST; n_x];
    let rows = inner_rows(grid);
    for &row in &rows {
        let (done, rest) = room.split_at_mut(row);
        least_of_rows(before.map(|offset| &done[row - offset..][..n_x]), &mut nearest);
        spread(&mut rest[..n_x], &nearest);
    }
    for &row in rows.iter().rev() {
        let (rest, done) = room.split_at_mut(row + n_x);
        least_of_rows(before.map(|offset| &done[offset - n_x..][..n_x]), &mut nearest);
        let row = &mut rest[row..];
        row.reverse();
        nearest.reverse();
        spread(row, &nearest);
        row.reverse();
    }
    for (room, &pass) in room.iter_mut().zip(&grid.passes) {
        if pass == PassGrid::OUTSIDE {
            *room = BEYOND;
        }
    }
    room
}

/// The first cells of the rows along x that hold the block, increasing.
fn inner_rows(grid: &PassGrid) -> Vec<usize> {
    let (dims, [_, stride_y, stride_z]) = (grid.block.dims().as_usizevec3(), grid.padded.strides());
    (1..=dims.z).flat_map(|z| (1..=dims.y).map(move |y| z * stride_z + y * stride_y)).collect()
}

fn least_of_rows([a, b, c, d]: [&[u8]; 4], least: &mut [u8]) {
    for (x, least) in least.iter_mut().enumerate() {
        *least = a[x].min(b[x]).min(c[x].min(d[x]));
    }
}

/// Lowers the room in a row to one more than that of the cells beside it in other rows, and of the cell before.
fn spread(row: &mut [u8], nearest: &[u8]) {
    for x in 1..row.len() - 1 {
        let beside = nearest[x - 1].min(nearest[x]).min(nearest[x + 1]).min(row[x - 1]);
        row[x] = row[x].min(beside.saturating_add(1)).min(FARTHEST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::Snapshot;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: the nearest of all voxels that are not clear.
        #[test]
        fn room_reaches_to_the_nearest_voxel_that_is_not_clear(
            dims in prop::array::uniform3(1_u32..9), found in prop::collection::vec((0_usize..512, 0.0_f32..0.9), 0..4),
        ) {
            let block = VoxelBlock::new(IVec3::splat(-3), UVec3::from_array(dims)).unwrap();
            let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
            let mut grid = PassGrid::of_passes(&snapshot, &vec![1.0; block.n_voxels()]);
            let found = found.into_iter().map(|(i, pass)| (block.key(i % block.n_voxels()), pass));
            let found: Vec<(IVec3, f32)> = found.collect();
            for &(key, pass) in &found {
                let cell = grid.padded.index(key).unwrap();
                grid.passes[cell] = pass;
            }
            for (cell, &room) in room(&grid).iter().enumerate() {
                let key = grid.padded.key(cell);
                let nearest = found.iter().map(|(other, _)| (*other - key).abs().max_element() as u8).min();
                let expected = if block.index(key).is_some() { nearest.unwrap_or(FARTHEST) } else { BEYOND };
                prop_assert_eq!(room, expected);
            }
        }
    }
}
