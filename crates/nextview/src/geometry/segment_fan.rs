use super::lanes::{FIRST_INDEX, LANES, Lanes, any, cell, load, round, store};
use super::{VoxelBlock, VoxelKey};
use crate::instructions::instructions;
use glam::DVec3;
use pulp::{Simd, WithSimd};
use std::sync::atomic::{AtomicU8, Ordering};

/// Segments from one point through a box of voxels, several walked at a time in the lanes of vector
/// instructions.
///
/// Each is walked exactly as by [`SegmentWalk::within`](super::SegmentWalk::within), with the same operations
/// on the same numbers, but only the crossed voxels are recorded. That takes a third of the time: a step has
/// no branch that depends on the segment, and marks with one store per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SegmentFan {
    /// The start of all segments, in units of voxels.
    pub from: DVec3,
    /// The box that clips them, both ends included.
    pub min: VoxelKey,
    /// See `min`.
    pub max: VoxelKey,
    /// Numbers the cells to mark; contains the box, and at most 2^31 voxels.
    pub cells: VoxelBlock,
}

impl SegmentFan {
    /// Sets to 1 the cell of every voxel that a segment crosses before the voxel in which it ends. The ends
    /// are in units of voxels. There must be one more cell than voxels in the block; the value of the extra
    /// one is meaningless.
    pub fn mark_crossed(&self, ends: &[DVec3], cells: &[AtomicU8]) {
        assert_eq!(cells.len(), self.cells.n_voxels() + 1);
        instructions().dispatch(FanCrossing { fan: self, ends, cells });
    }
}

struct FanCrossing<'a> {
    fan: &'a SegmentFan,
    ends: &'a [DVec3],
    cells: &'a [AtomicU8],
}

impl WithSimd for FanCrossing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for ends in self.ends.chunks(S::F64_LANES) {
            if let Some(mut walk) = Walk::new(simd, self.fan, ends) {
                walk.mark(simd, self.cells);
            }
        }
    }
}

/// Segments under way; the names are those of `SegmentWalk`. The code below has no closures: a closure that
/// is not inlined is compiled without vector instructions, so that each operation becomes a call.
struct Walk<S: Simd> {
    axes: [FanAxis<S>; 3],
    /// The cell of the current voxel, and that of the end or a nonexistent one, as an [index](cell).
    index: S::f64s,
    end_index: S::f64s,
    /// The cell that ended segments mark.
    spare: S::f64s,
    goes_on: S::m64s,
}

#[derive(Clone, Copy)]
struct FanAxis<S: Simd> {
    t_next: S::f64s,
    t_first: S::f64s,
    t_delta: S::f64s,
    n: S::f64s,
    n_end: S::f64s,
    /// Whether all steps are done, and the crossing after them: infinite, or the one that leaves the box.
    done: S::m64s,
    t_last: S::f64s,
    /// Change of the index per step.
    stride: S::f64s,
}

/// One axis before the walk has entered the box.
#[derive(Clone, Copy)]
struct Approach<S: Simd> {
    t_first: S::f64s,
    t_delta: S::f64s,
    speed: S::f64s,
    step: S::f64s,
    n_end: S::f64s,
    /// Steps left to reach the box.
    short: S::f64s,
}

/// The same axis of all segments.
struct AxisInput {
    from: f64,
    to: Lanes,
    to_floor: Lanes,
    min: f64,
    max: f64,
}

impl AxisInput {
    #[inline(always)]
    fn new(fan: &SegmentFan, ends: &[DVec3], axis: usize) -> Self {
        // Lanes without a segment repeat the first one.
        let mut to: Lanes = [ends[0][axis]; LANES];
        for (lane, end) in ends.iter().enumerate() {
            to[lane] = end[axis];
        }
        let mut to_floor = to;
        for value in &mut to_floor {
            *value = value.floor();
        }
        let (min, max) = (fan.min[axis] as f64, fan.max[axis] as f64);
        Self { from: fan.from[axis], to, to_floor, min, max }
    }
}

impl<S: Simd> Approach<S> {
    #[inline(always)]
    fn new(simd: S, input: &AxisInput) -> Self {
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (from, from_floor) = (simd.splat_f64s(input.from), simd.splat_f64s(input.from.floor()));
        let direction = simd.sub_f64s(load::<S>(&input.to, 0), from);
        let forward = simd.less_than_f64s(zero, direction);
        let backward = simd.less_than_f64s(direction, zero);
        let border = simd.select_f64s(forward, simd.splat_f64s(input.from.floor() + 1.0), from_floor);
        let inverse = simd.div_f64s(one, direction);
        let ahead = simd.splat_f64s(input.min - input.from.floor());
        let behind = simd.splat_f64s(input.from.floor() - input.max);
        Self {
            t_first: simd.mul_f64s(simd.sub_f64s(border, from), inverse),
            t_delta: simd.abs_f64s(inverse),
            speed: simd.abs_f64s(direction),
            step: simd.select_f64s(forward, one, simd.select_f64s(backward, simd.splat_f64s(-1.0), zero)),
            n_end: simd.abs_f64s(simd.sub_f64s(load::<S>(&input.to_floor, 0), from_floor)),
            short: simd.select_f64s(backward, behind, ahead),
        }
    }

    #[inline(always)]
    fn crossing(&self, simd: S, n: S::f64s) -> S::f64s {
        simd.add_f64s(self.t_first, simd.mul_f64s(n, self.t_delta))
    }

    /// Whether the crossing after `n` steps is before `t`, or at `t` if `also_at`.
    #[inline(always)]
    fn crossed(&self, simd: S, n: S::f64s, t: S::f64s, also_at: S::m64s) -> S::m64s {
        let at = self.crossing(simd, n);
        let touches = simd.and_m64s(also_at, simd.equal_f64s(at, t));
        simd.or_m64s(simd.less_than_f64s(at, t), touches)
    }

    /// Returns the number of crossings before `t`, and at `t` if `also_at`.
    #[inline(always)]
    fn n_crossings(&self, simd: S, t: S::f64s, also_at: S::m64s) -> S::f64s {
        let (zero, half, one) = (simd.splat_f64s(0.0), simd.splat_f64s(0.5), simd.splat_f64s(1.0));
        // Rounding may put this guess off by one; NaN, for a walk parallel to the borders, becomes 0.
        let guess = simd.mul_f64s(simd.sub_f64s(t, self.t_first), self.speed);
        let guess = simd.select_f64s(simd.less_than_f64s(guess, self.n_end), guess, self.n_end);
        let guess = simd.select_f64s(simd.less_than_f64s(zero, guess), guess, zero);
        let rounded = round(simd, simd.add_f64s(guess, half));
        let mut n = simd.select_f64s(simd.less_than_f64s(rounded, self.n_end), rounded, self.n_end);
        loop {
            let before = simd.sub_f64s(n, one);
            let too_many = simd.and_m64s(
                simd.less_than_f64s(zero, n),
                simd.not_m64s(self.crossed(simd, before, t, also_at)),
            );
            let too_few =
                simd.and_m64s(simd.less_than_f64s(n, self.n_end), self.crossed(simd, n, t, also_at));
            if !any(simd, simd.or_m64s(too_many, too_few)) {
                return n;
            }
            n = simd.select_f64s(too_many, before, simd.select_f64s(too_few, simd.add_f64s(n, one), n));
        }
    }
}

impl<S: Simd> FanAxis<S> {
    /// Returns the axis after `n` steps, with `room` more in the box.
    #[inline(always)]
    fn new(simd: S, approach: &Approach<S>, n: S::f64s, room: S::f64s, stride: f64) -> Self {
        let limit = simd.add_f64s(n, room);
        let is_cut = simd.less_than_f64s(limit, approach.n_end);
        let infinite = simd.splat_f64s(f64::INFINITY);
        let mut axis = Self {
            t_next: infinite,
            t_first: approach.t_first,
            t_delta: approach.t_delta,
            n,
            n_end: simd.select_f64s(is_cut, limit, approach.n_end),
            done: is_cut,
            t_last: simd.select_f64s(is_cut, approach.crossing(simd, limit), infinite),
            stride: simd.mul_f64s(approach.step, simd.splat_f64s(stride)),
        };
        axis.find_next(simd);
        axis
    }

    #[inline(always)]
    fn find_next(&mut self, simd: S) {
        let next = simd.add_f64s(self.t_first, simd.mul_f64s(self.n, self.t_delta));
        self.done = simd.less_than_or_equal_f64s(self.n_end, self.n);
        self.t_next = simd.select_f64s(self.done, self.t_last, next);
    }

    /// Makes a step in the lanes where it is this axis' turn.
    #[inline(always)]
    fn advance(&mut self, simd: S, turn: S::m64s) {
        self.n = simd.select_f64s(turn, simd.add_f64s(self.n, simd.splat_f64s(1.0)), self.n);
        self.find_next(simd);
    }
}

impl<S: Simd> Walk<S> {
    /// `None` if no segment crosses the box.
    #[inline(always)]
    fn new(simd: S, fan: &SegmentFan, ends: &[DVec3]) -> Option<Self> {
        let x = AxisInput::new(fan, ends, 0);
        let y = AxisInput::new(fan, ends, 1);
        let z = AxisInput::new(fan, ends, 2);
        let approaches = [Approach::new(simd, &x), Approach::new(simd, &y), Approach::new(simd, &z)];
        let mut entry = EnteringSegments::new(simd, &approaches);
        let x = entry.enter(simd, fan, &approaches[0], &x, 0);
        let y = entry.enter(simd, fan, &approaches[1], &y, 1);
        let z = entry.enter(simd, fan, &approaches[2], &z, 2);
        if !any(simd, entry.goes_on) {
            return None;
        }
        Some(Self {
            axes: [x, y, z],
            index: entry.index,
            end_index: simd.select_f64s(entry.end_is_in, entry.end_index, simd.splat_f64s(-1.0)),
            spare: simd.splat_f64s(FIRST_INDEX + fan.cells.n_voxels() as f64),
            goes_on: entry.goes_on,
        })
    }

    #[inline(always)]
    fn mark(&mut self, simd: S, cells: &[AtomicU8]) {
        let mut marked: Lanes = [0.0; LANES];
        loop {
            // Checking whether any lane continues costs as much as a step.
            for _ in 0..4 {
                self.goes_on =
                    simd.and_m64s(self.goes_on, simd.not_m64s(simd.equal_f64s(self.index, self.end_index)));
                store::<S>(&mut marked, 0, simd.select_f64s(self.goes_on, self.index, self.spare));
                for &index in &marked[..S::F64_LANES] {
                    if let Some(cell) = cells.get(cell(index)) {
                        cell.store(1, Ordering::Relaxed);
                    }
                }
                self.advance(simd);
            }
            if !any(simd, self.goes_on) {
                return;
            }
        }
    }

    #[inline(always)]
    fn advance(&mut self, simd: S) {
        let [x, y, z] = &mut self.axes;
        let x_turn = simd.and_m64s(
            simd.less_than_or_equal_f64s(x.t_next, y.t_next),
            simd.less_than_or_equal_f64s(x.t_next, z.t_next),
        );
        let y_before_z = simd.less_than_or_equal_f64s(y.t_next, z.t_next);
        let y_turn = simd.and_m64s(y_before_z, simd.not_m64s(x_turn));
        let z_turn = simd.not_m64s(simd.or_m64s(x_turn, y_before_z));
        let is_over = simd.or_m64s(
            simd.and_m64s(x_turn, x.done),
            simd.or_m64s(simd.and_m64s(y_turn, y.done), simd.and_m64s(z_turn, z.done)),
        );
        self.goes_on = simd.and_m64s(self.goes_on, simd.not_m64s(is_over));
        let stride = simd.select_f64s(y_turn, y.stride, z.stride);
        self.index = simd.add_f64s(self.index, simd.select_f64s(x_turn, x.stride, stride));
        x.advance(simd, x_turn);
        y.advance(simd, y_turn);
        z.advance(simd, z_turn);
    }
}

/// Segments that enter the box, one axis after the other.
struct EnteringSegments<S: Simd> {
    /// The last crossing that brings a segment into the slabs of the box, and its axis; minus infinity and -1
    /// if it starts in all of them.
    t_in: S::f64s,
    entering: S::f64s,
    /// As in [`Walk`], over the axes so far.
    index: S::f64s,
    end_index: S::f64s,
    end_is_in: S::m64s,
    goes_on: S::m64s,
}

impl<S: Simd> EnteringSegments<S> {
    #[inline(always)]
    fn new(simd: S, approaches: &[Approach<S>; 3]) -> Self {
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let mut t_in = simd.splat_f64s(f64::NEG_INFINITY);
        let mut entering = simd.splat_f64s(-1.0);
        for (axis, approach) in approaches.iter().enumerate() {
            let t = approach.crossing(simd, simd.sub_f64s(approach.short, one));
            let enters = simd.less_than_f64s(zero, approach.short);
            let is_later = simd.and_m64s(enters, simd.less_than_or_equal_f64s(t_in, t));
            t_in = simd.select_f64s(is_later, t, t_in);
            entering = simd.select_f64s(is_later, simd.splat_f64s(axis as f64), entering);
        }
        let (index, all) = (simd.splat_f64s(FIRST_INDEX), simd.equal_f64s(zero, zero));
        Self { t_in, entering, index, end_index: index, end_is_in: all, goes_on: all }
    }

    #[inline(always)]
    fn enter(
        &mut self,
        simd: S,
        fan: &SegmentFan,
        approach: &Approach<S>,
        input: &AxisInput,
        axis: usize,
    ) -> FanAxis<S> {
        let also_at = simd.less_than_or_equal_f64s(simd.splat_f64s(axis as f64), self.entering);
        let n = approach.n_crossings(simd, self.t_in, also_at);
        let key = simd.add_f64s(simd.splat_f64s(input.from.floor()), simd.mul_f64s(approach.step, n));
        let (min, max) = (simd.splat_f64s(input.min), simd.splat_f64s(input.max));
        let to_floor = load::<S>(&input.to_floor, 0);
        self.goes_on = simd.and_m64s(self.goes_on, is_within(simd, key, min, max));
        self.goes_on =
            simd.and_m64s(self.goes_on, simd.less_than_or_equal_f64s(approach.short, approach.n_end));
        self.end_is_in = simd.and_m64s(self.end_is_in, is_within(simd, to_floor, min, max));
        let stride = fan.cells.strides()[axis] as f64;
        let first = simd.splat_f64s(fan.cells.min()[axis] as f64);
        self.index = simd.add_f64s(self.index, place(simd, key, first, stride));
        self.end_index = simd.add_f64s(self.end_index, place(simd, to_floor, first, stride));
        let backward = simd.less_than_f64s(approach.step, simd.splat_f64s(0.0));
        let room = simd.select_f64s(backward, simd.sub_f64s(key, min), simd.sub_f64s(max, key));
        FanAxis::new(simd, approach, n, room, stride)
    }
}

#[inline(always)]
fn is_within<S: Simd>(simd: S, key: S::f64s, min: S::f64s, max: S::f64s) -> S::m64s {
    simd.and_m64s(simd.less_than_or_equal_f64s(min, key), simd.less_than_or_equal_f64s(key, max))
}

/// Returns the contribution of a coordinate to the index of a cell.
#[inline(always)]
fn place<S: Simd>(simd: S, key: S::f64s, first: S::f64s, stride: f64) -> S::f64s {
    simd.mul_f64s(simd.sub_f64s(key, first), simd.splat_f64s(stride))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::SegmentWalk;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    /// Marks by one walk at a time.
    fn by_walks(fan: &SegmentFan, ends: &[DVec3]) -> Vec<u8> {
        let mut cells = vec![0; fan.cells.n_voxels()];
        for &end in ends {
            let Some(mut walk) = SegmentWalk::within(fan.from, end, fan.min, fan.max) else { continue };
            while walk.key() != end.floor().as_ivec3() {
                cells[fan.cells.index(walk.key()).unwrap()] = 1;
                if walk.advance().is_none() {
                    break;
                }
            }
        }
        cells
    }

    fn marks(fan: &SegmentFan, ends: &[DVec3], mark: impl Fn(FanCrossing)) -> Vec<u8> {
        let cells: Vec<AtomicU8> = (0..=fan.cells.n_voxels()).map(|_| AtomicU8::new(0)).collect();
        mark(FanCrossing { fan, ends, cells: &cells });
        cells.into_iter().map(AtomicU8::into_inner).take(fan.cells.n_voxels()).collect()
    }

    fn position() -> impl Strategy<Value = DVec3> {
        (-9.0..9.0, -9.0..9.0, -9.0..9.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// Positions with many exact ties: multiples of a quarter.
    fn tied() -> impl Strategy<Value = DVec3> {
        (-36..36, -36..36, -36..36).prop_map(|(x, y, z)| DVec3::new(x as f64, y as f64, z as f64) * 0.25)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn marks_what_the_walks_cross(
            (from, ends) in prop_oneof![
                (position(), prop::collection::vec(position(), 1..20)),
                (tied(), prop::collection::vec(tied(), 1..20)),
            ],
            min in prop::array::uniform3(-6..3), dims in prop::array::uniform3(0..9),
        ) {
            let min = IVec3::from_array(min);
            let max = min + IVec3::from_array(dims);
            let cells = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(24)).unwrap();
            let fan = SegmentFan { from, min, max, cells };
            let expected = by_walks(&fan, &ends);
            let public = marks(&fan, &ends, |crossing| fan.mark_crossed(&ends, crossing.cells));
            prop_assert_eq!(&public, &expected);
            prop_assert_eq!(&marks(&fan, &ends, |crossing| crossing.with_simd(pulp::Scalar)), &expected);
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = pulp::x86::V3::try_new() {
                prop_assert_eq!(&marks(&fan, &ends, |crossing| Simd::vectorize(avx2, crossing)), &expected);
            }
        }
    }
}
