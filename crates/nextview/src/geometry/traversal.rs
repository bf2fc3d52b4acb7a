use super::VoxelKey;
use glam::{DVec3, IVec3};

/// Walks all voxels that a straight segment or ray crosses, in order, each once (Amanatides & Woo 1987).
///
/// Crossings through an edge or a corner step along the lower axis first. Border crossings are computed from
/// the start, not accumulated: the walk [`within`](Self::within) a block is bit for bit the part of the whole
/// walk in the block. A segment's steps along each axis are counted, so rounding cannot make the walk miss
/// its end.
///
/// Positions must be within 2^30 voxels of the origin: coordinates beyond count as 2^30, and NaN as 0.
///
/// ```
/// use glam::{DVec3, IVec3};
/// use nextview::geometry::SegmentWalk;
///
/// let mut walk = SegmentWalk::new(DVec3::new(0.5, 0.5, 0.5), DVec3::new(2.5, 1.0, 0.5));
/// let mut keys = vec![walk.key()];
/// while walk.advance().is_some() {
///     keys.push(walk.key());
/// }
/// assert_eq!(keys, [IVec3::new(0, 0, 0), IVec3::new(1, 0, 0), IVec3::new(2, 0, 0), IVec3::new(2, 1, 0)]);
/// ```
#[derive(Clone, Debug)]
pub struct SegmentWalk {
    key: VoxelKey,
    step: IVec3,
    // Three fields rather than an array: with an index known only at run time, the walk's state would live in
    // memory and a step would cost three times as much.
    x: WalkAxis,
    y: WalkAxis,
    z: WalkAxis,
}

/// The progress of a walk along one axis. Positions along the walk are measured in lengths of its direction.
#[derive(Clone, Copy, Debug)]
struct WalkAxis {
    /// Position of the next border crossing; infinite once the axis is done.
    t_next: f64,
    /// Position of the first border crossing, and the distance between crossings.
    t_first: f64,
    t_delta: f64,
    /// Borders crossed per length of the direction.
    speed: f64,
    /// Steps made so far, and in total, up to the segment's end or the last voxel of the block.
    n: f64,
    n_end: f64,
    /// Whether only this axis is done after all its steps, rather than the whole walk at the next crossing.
    then_done: bool,
}

impl WalkAxis {
    fn new(from: f64, direction: f64, n_end: f64) -> Self {
        let inverse = 1.0 / direction;
        let border = if direction > 0.0 { from.floor() + 1.0 } else { from.floor() };
        let (t_first, t_delta, speed) = ((border - from) * inverse, inverse.abs(), direction.abs());
        let mut axis =
            Self { t_next: 0.0, t_first, t_delta, speed, n: 0.0, n_end, then_done: n_end.is_finite() };
        axis.find_next();
        axis
    }

    /// Returns the position of the border crossing after `n` steps, computed directly so that rounding does
    /// not accumulate.
    #[inline(always)]
    fn crossing(&self, n: f64) -> f64 {
        self.t_first + n * self.t_delta
    }

    #[inline(always)]
    fn find_next(&mut self) {
        let done = self.n >= self.n_end && self.then_done;
        self.t_next = if done { f64::INFINITY } else { self.crossing(self.n) };
    }

    /// Makes a step; false at the end of the walk.
    #[inline(always)]
    fn advance(&mut self) -> bool {
        let goes_on = self.n < self.n_end;
        self.n += goes_on as i32 as f64;
        self.find_next();
        goes_on
    }

    /// Makes all steps before `t`, and at `t` if `also_at`, but at most `most`. Returns their number.
    fn skip_to(&mut self, t: f64, also_at: bool, most: i32) -> i32 {
        let crossed = |axis: &Self, n: f64| axis.crossing(n) < t || (also_at && axis.crossing(n) == t);
        // Rounding puts this guess off by at most one, unless the numbers are nonsense; NaN, for a walk
        // parallel to the borders, becomes 0.
        let guess = ((t - self.t_first) * self.speed) as u32;
        let most = self.n_end.min(most.into());
        // The first two loops move `low` and `high` apart until the number is between them.
        let mut low = (guess as f64 + 1.0).min(most);
        let (mut high, mut gap) = (low, 1.0);
        while low > 0.0 && !crossed(self, low - 1.0) {
            (low, high, gap) = ((low - gap).max(0.0), low - 1.0, 2.0 * gap);
        }
        while high < most && crossed(self, high) {
            (low, high, gap) = (high + 1.0, (high + gap).min(most), 2.0 * gap);
        }
        while low < high {
            let middle = ((low + high) / 2.0).floor();
            (low, high) = if crossed(self, middle) { (middle + 1.0, high) } else { (low, middle) };
        }
        self.n = low;
        low as i32
    }

    /// Ends the walk after `room` more steps, unless the axis is done earlier.
    fn end_after(&mut self, room: i32) {
        if self.n + (room as f64) < self.n_end {
            (self.n_end, self.then_done) = (self.n + room as f64, false);
        }
        self.find_next();
    }
}

/// Clamps a position so that keys and their differences fit 32 bits.
fn bounded(position: DVec3) -> DVec3 {
    const REACH: f64 = (1 << 30) as f64;
    DVec3::select(position.is_nan_mask(), DVec3::ZERO, position)
        .clamp(DVec3::splat(-REACH), DVec3::splat(REACH))
}

impl SegmentWalk {
    /// Returns the walk between two positions in units of voxels.
    pub fn new(from: DVec3, to: DVec3) -> Self {
        let (from, to) = (bounded(from), bounded(to));
        let n_steps = (to.floor() - from.floor()).abs();
        Self::with_steps(from, to - from, n_steps)
    }

    /// Returns the part of the walk between two positions in the block from voxel `min` to voxel `max`, both
    /// included; `None` if it does not cross the block.
    pub fn within(from: DVec3, to: DVec3, min: VoxelKey, max: VoxelKey) -> Option<Self> {
        Self::new(from, to).enter(min, max)
    }

    /// As [`within`](Self::within), for the infinite ray from a position along a direction.
    pub fn ray_within(from: DVec3, direction: DVec3, min: VoxelKey, max: VoxelKey) -> Option<Self> {
        let n_steps = DVec3::select(direction.cmpeq(DVec3::ZERO), DVec3::ZERO, DVec3::INFINITY);
        Self::with_steps(bounded(from), direction, n_steps).enter(min, max)
    }

    fn with_steps(from: DVec3, direction: DVec3, n_steps: DVec3) -> Self {
        let step = IVec3::from_array(direction.to_array().map(|d| (d > 0.0) as i32 - (d < 0.0) as i32));
        let axis = |i: usize| WalkAxis::new(from[i], direction[i], n_steps[i]);
        Self { key: from.floor().as_ivec3(), step, x: axis(0), y: axis(1), z: axis(2) }
    }

    /// Skips to the first voxel in the block and ends the walk at the last.
    fn enter(mut self, min: VoxelKey, max: VoxelKey) -> Option<Self> {
        let mut axes = [self.x, self.y, self.z];
        // The last crossing that brings the walk into the block's slabs.
        let mut last: Option<(f64, usize)> = None;
        for (i, axis) in axes.iter().enumerate() {
            let short = match self.step[i] < 0 {
                true => self.key[i].saturating_sub(max[i]),
                false => min[i].saturating_sub(self.key[i]),
            };
            if short > 0 {
                if axis.n_end < short as f64 {
                    return None;
                }
                let t = axis.crossing(short as f64 - 1.0);
                last = if last.is_none_or(|(t_last, _)| t >= t_last) { Some((t, i)) } else { last };
            }
        }
        for (i, axis) in axes.iter_mut().enumerate() {
            if let Some((t, entering)) = last {
                // A walk one step past the block has missed it.
                let far = if self.step[i] < 0 { min[i] } else { max[i] };
                let most = i32::try_from(self.key[i].abs_diff(far)).unwrap_or(i32::MAX).saturating_add(1);
                self.key[i] += self.step[i] * axis.skip_to(t, i <= entering, most);
            }
            if self.key[i] < min[i] || self.key[i] > max[i] {
                return None;
            }
            axis.end_after(if self.step[i] < 0 { self.key[i] - min[i] } else { max[i] - self.key[i] });
        }
        [self.x, self.y, self.z] = axes;
        Some(self)
    }

    /// Returns the current voxel.
    pub fn key(&self) -> VoxelKey {
        self.key
    }

    /// Returns the direction of the steps along each axis: -1, 0 or 1.
    pub fn step(&self) -> IVec3 {
        self.step
    }

    /// Moves to the next voxel and returns the axis of the step; `None` at the end.
    #[inline(always)]
    pub fn advance(&mut self) -> Option<usize> {
        let (x, y, z) = (self.x.t_next, self.y.t_next, self.z.t_next);
        if x <= y && x <= z {
            self.key.x += self.step.x;
            self.x.advance().then_some(0)
        } else if y <= z {
            self.key.y += self.step.y;
            self.y.advance().then_some(1)
        } else {
            self.key.z += self.step.z;
            self.z.advance().then_some(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn keys(from: DVec3, to: DVec3) -> Vec<IVec3> {
        collect(SegmentWalk::new(from, to))
    }

    fn collect(mut walk: SegmentWalk) -> Vec<IVec3> {
        let mut keys = vec![walk.key()];
        while walk.advance().is_some() {
            keys.push(walk.key());
        }
        keys
    }

    /// The slow twin: dense samples along the segment.
    fn sampled(from: DVec3, to: DVec3) -> Vec<IVec3> {
        let mut keys: Vec<IVec3> =
            (0..=20_000).map(|i| from.lerp(to, i as f64 / 20_000.0).floor().as_ivec3()).collect();
        keys.dedup();
        keys
    }

    fn position() -> impl Strategy<Value = DVec3> {
        (-6.0..6.0, -6.0..6.0, -6.0..6.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn visits_every_voxel_that_fine_sampling_finds(from in position(), to in position()) {
            let walked = keys(from, to);
            for pair in walked.windows(2) {
                prop_assert_eq!((pair[0] - pair[1]).abs().element_sum(), 1, "neighbours share a face");
            }
            prop_assert_eq!(walked[0], from.floor().as_ivec3());
            prop_assert_eq!(walked[walked.len() - 1], to.floor().as_ivec3());
            // Sampling may skip a voxel that the segment only clips at a corner, but finds no others.
            let mut position = 0;
            for key in sampled(from, to) {
                let found = walked[position..].iter().position(|&k| k == key);
                prop_assert!(found.is_some(), "voxel {key} missed");
                position += found.unwrap_or(0);
            }
        }
    }

    /// Positions with many exact ties: multiples of a quarter.
    fn tied() -> impl Strategy<Value = DVec3> {
        (-24..24, -24..24, -24..24).prop_map(|(x, y, z)| DVec3::new(x as f64, y as f64, z as f64) * 0.25)
    }

    proptest! {
        #[test]
        fn within_a_block_it_is_the_same_walk(
            (from, to) in prop_oneof![(position(), position()), (tied(), tied())],
            min in prop::array::uniform3(-4..2), dims in prop::array::uniform3(0..5),
        ) {
            let min = IVec3::from_array(min);
            let max = min + IVec3::from_array(dims);
            let inside = |k: &IVec3| k.cmpge(min).all() && k.cmple(max).all();
            let expected: Vec<IVec3> = keys(from, to).into_iter().filter(inside).collect();
            let found = SegmentWalk::within(from, to, min, max).map(collect).unwrap_or_default();
            prop_assert_eq!(&found, &expected);
        }

        /// A segment that ends on a border may have turned there to reach its end; away from ties they agree.
        #[test]
        fn a_ray_goes_on_where_the_segment_ends(from in position(), to in position()) {
            let (min, max) = (IVec3::splat(-4), IVec3::splat(2));
            let segment = SegmentWalk::within(from, to, min, max).map(collect).unwrap_or_default();
            let ray = SegmentWalk::ray_within(from, to - from, min, max).map(collect).unwrap_or_default();
            prop_assert!(ray.starts_with(&segment), "{ray:?} {segment:?}");
        }
    }

    #[test]
    fn handles_points_axes_and_corners() {
        let origin = DVec3::splat(0.5);
        assert_eq!(keys(origin, origin), [IVec3::ZERO]);
        assert_eq!(keys(origin, DVec3::new(-1.5, 0.5, 0.5)).len(), 3);
        assert_eq!(keys(origin, DVec3::splat(2.5)).len(), 7, "through two corners, along the axes in turn");
        assert_eq!(keys(DVec3::ZERO, DVec3::new(0.0, 0.0, 2.0)).len(), 3, "along an edge, ends on borders");
    }
}
