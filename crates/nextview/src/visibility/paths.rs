use super::packet::{OUTSIDE, Packet, PacketAxis};
use super::pass_grid::PassGrid;
use crate::geometry::lanes::{LANES, Lanes, cell, load, store};
use pulp::Simd;

/// The voxels crossed by the rays of a packet, found by walking them side by side.
///
/// The twin of the walk of a single ray in [`RayCaster`](super::RayCaster): the same operations in the same
/// order, with selections instead of branches. A branch on the axis of the next step would be mispredicted
/// half of the time.
#[derive(Debug)]
pub(crate) struct Paths {
    /// Buffer longer than any path.
    steps: Vec<PathStep>,
    /// Number of crossings of each ray, in the form of an [index](cell).
    len: Lanes,
    /// Number of crossings before the first that weakens the ray, in the same form; may exceed `len` if there
    /// is none.
    n_clear: Lanes,
}

#[derive(Clone, Copy, Debug)]
struct PathStep {
    index: Lanes,
    /// Visibility in front of the cell.
    visibility: [f32; LANES],
}

impl Paths {
    /// Allocates paths through a grid.
    pub(super) fn new(grid: &PassGrid) -> Self {
        let longest = grid.padded.dims().element_sum() as usize + 1;
        let step = PathStep { index: [OUTSIDE; LANES], visibility: [1.0; LANES] };
        Self { steps: vec![step; longest], len: [OUTSIDE; LANES], n_clear: [OUTSIDE; LANES] }
    }

    /// Returns the cells and visibilities that a ray crosses, from the first cell that weakens it.
    pub(super) fn weakened(&self, lane: usize) -> impl Iterator<Item = (usize, f32)> {
        let (start, end) = (cell(self.n_clear[lane]), cell(self.len[lane]));
        let steps = self.steps[..end].get(start..).unwrap_or_default();
        steps.iter().map(move |step| (cell(step.index[lane]), step.visibility[lane]))
    }

    /// Follows the rays of a packet through its grid until all have ended.
    #[inline(always)]
    pub(super) fn follow<S: Simd>(&mut self, simd: S, packet: &Packet, grid: &PassGrid, fade_limit: f32) {
        for part in 0..LANES / S::F64_LANES {
            self.follow_part(simd, part, packet, grid, fade_limit);
        }
    }

    #[inline(always)]
    fn follow_part<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        packet: &Packet,
        grid: &PassGrid,
        fade_limit: f32,
    ) {
        let (zero, one, outside) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0), simd.splat_f64s(OUTSIDE));
        let fade_limit = simd.splat_f64s(fade_limit as f64);
        let [x, y, z] = &packet.axes;
        let mut axes =
            [PathAxis::<S>::load(x, part), PathAxis::<S>::load(y, part), PathAxis::<S>::load(z, part)];
        let mut index = load::<S>(&packet.index, part);
        let mut visibility = [1.0; LANES];
        let (mut len, mut n_clear) = (outside, outside);
        let mut goes_on = simd.less_than_f64s(zero, one);
        for step in &mut self.steps {
            step.record::<S>(part, index, &visibility);
            // The end of a ray is known only after many cycles: to avoid waiting for it, the ray may go a
            // step too far.
            let may_move = goes_on;
            let (pass, after) = step.pass::<S>(simd, part, packet, grid, &mut visibility);
            let crosses = simd.and_m64s(goes_on, simd.greater_than_f64s(pass, zero));
            len = simd.add_f64s(len, simd.select_f64s(crosses, one, zero));
            n_clear = simd.add_f64s(n_clear, simd.select_f64s(simd.equal_f64s(after, one), one, zero));
            goes_on = simd.and_m64s(crosses, simd.greater_than_or_equal_f64s(after, fade_limit));
            if simd.first_true_m64s(goes_on) == S::F64_LANES {
                break;
            }
            let stride = advance(simd, &mut axes);
            index = simd.select_f64s(may_move, simd.add_f64s(index, stride), outside);
        }
        store::<S>(&mut self.len, part, len);
        store::<S>(&mut self.n_clear, part, n_clear);
    }
}

impl PathStep {
    #[inline(always)]
    fn record<S: Simd>(&mut self, part: usize, index: S::f64s, visibility: &[f32; LANES]) {
        store::<S>(&mut self.index, part, index);
        self.visibility[part * S::F64_LANES..][..S::F64_LANES].copy_from_slice(&visibility[..S::F64_LANES]);
    }

    /// The shares that the cells pass on, and the visibility behind them.
    #[inline(always)]
    fn pass<S: Simd>(
        &self,
        simd: S,
        part: usize,
        packet: &Packet,
        grid: &PassGrid,
        visibility: &mut [f32; LANES],
    ) -> (S::f64s, S::f64s) {
        let mut passes = [0.0_f32; LANES];
        #[allow(
            clippy::needless_range_loop,
            reason = "iterators are not always inlined into vector instructions"
        )]
        for lane in 0..S::F64_LANES {
            let cell = cell(self.index[part * S::F64_LANES + lane]);
            passes[lane] = grid.passes.get(cell).copied().unwrap_or(PassGrid::OUTSIDE);
        }
        let (mut pass, mut after) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..S::F64_LANES {
            pass[lane] = passes[lane] as f64;
        }
        let outside = simd.splat_f64s(PassGrid::OUTSIDE as f64);
        if simd.first_true_m64s(simd.less_than_f64s(load::<S>(&pass, 0), outside)) < S::F64_LANES {
            self.pass_beside(part * S::F64_LANES, packet, grid, &mut passes[..S::F64_LANES]);
        }
        for lane in 0..S::F64_LANES {
            visibility[lane] *= passes[lane];
            (pass[lane], after[lane]) = (passes[lane] as f64, visibility[lane] as f64);
        }
        (load::<S>(&pass, 0), load::<S>(&after, 0))
    }

    /// Fills in the shares of cells in which parts end rays, for the lanes from `first` on.
    #[cold]
    fn pass_beside(&self, first: usize, packet: &Packet, grid: &PassGrid, passes: &mut [f32]) {
        for (lane, pass) in (first..).zip(passes).filter(|(_, pass)| **pass < PassGrid::OUTSIDE) {
            *pass = grid.beside(cell(self.index[lane]), packet.origin, packet.direction(lane));
        }
    }
}

/// The walks along one axis.
struct PathAxis<S: Simd> {
    next: S::f64s,
    step: S::f64s,
    stride: S::f64s,
}

impl<S: Simd> PathAxis<S> {
    #[inline(always)]
    fn load(axis: &PacketAxis, part: usize) -> Self {
        let (next, step, stride) =
            (load::<S>(&axis.next, part), load::<S>(&axis.step, part), load::<S>(&axis.stride, part));
        Self { next, step, stride }
    }

    #[inline(always)]
    fn cross(&mut self, simd: S, crosses: S::m64s) {
        self.next = simd.select_f64s(crosses, simd.add_f64s(self.next, self.step), self.next);
    }
}

/// Moves every ray over its next border, on the lowest axis where several are equal, and returns how the
/// indices move.
#[inline(always)]
fn advance<S: Simd>(simd: S, [x, y, z]: &mut [PathAxis<S>; 3]) -> S::f64s {
    let (x_y, x_z) =
        (simd.less_than_or_equal_f64s(x.next, y.next), simd.less_than_or_equal_f64s(x.next, z.next));
    let (x_first, y_z) = (simd.and_m64s(x_y, x_z), simd.less_than_or_equal_f64s(y.next, z.next));
    let not_x = simd.not_m64s(x_first);
    x.cross(simd, x_first);
    y.cross(simd, simd.and_m64s(not_x, y_z));
    z.cross(simd, simd.and_m64s(not_x, simd.not_m64s(y_z)));
    simd.select_f64s(x_first, x.stride, simd.select_f64s(y_z, y.stride, z.stride))
}
