use super::VoxelKey;
use glam::{DVec3, IVec3};

/// Walks all voxels that a straight segment or ray crosses, in order, each once (Amanatides & Woo 1987).
///
/// Crossings through an edge or a corner go along the lower axis first. Border crossings are computed from the
/// start, not accumulated, so that the walk [`within`](Self::within) a block is bit for bit the part of the whole walk
/// that lies in the block. A segment's steps along each axis are counted, so that rounding cannot make the
/// walk miss its end.
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
    from: DVec3,
    inverse: DVec3,
    /// Where the next border of each axis is crossed, in lengths of the direction; infinite once the axis is done.
    t_next: [f64; 3],
    /// Steps still to go along each axis, up to the segment's end or the last voxel of the block.
    remaining: [u32; 3],
    /// Whether the axis is done after them, rather than the walk at the next crossing.
    then_done: [bool; 3],
}

impl SegmentWalk {
    /// The walk between two positions in units of voxels.
    pub fn new(from: DVec3, to: DVec3) -> Self {
        let n_steps = (to.floor().as_ivec3() - from.floor().as_ivec3()).abs().to_array();
        let mut walk = Self::start(from, to - from);
        walk.remaining = n_steps.map(|n| n as u32);
        walk.find_next();
        walk
    }

    /// The part of the walk between two positions that lies in the block from voxel `min` to voxel `max`, both
    /// included; none if it does not cross the block.
    pub fn within(from: DVec3, to: DVec3, min: VoxelKey, max: VoxelKey) -> Option<Self> {
        Self::new(from, to).enter(min, max)
    }

    /// The same for the endless ray from a position along a direction.
    pub fn ray_within(from: DVec3, direction: DVec3, min: VoxelKey, max: VoxelKey) -> Option<Self> {
        let mut walk = Self::start(from, direction);
        for axis in 0..3 {
            (walk.remaining[axis], walk.then_done[axis]) =
                if direction[axis] == 0.0 { (0, true) } else { (u32::MAX, false) };
        }
        walk.find_next();
        walk.enter(min, max)
    }

    fn start(from: DVec3, direction: DVec3) -> Self {
        let step = IVec3::from_array(direction.to_array().map(|d| (d > 0.0) as i32 - (d < 0.0) as i32));
        let (key, inverse) = (from.floor().as_ivec3(), 1.0 / direction);
        Self { key, step, from, inverse, t_next: [0.0; 3], remaining: [0; 3], then_done: [true; 3] }
    }

    /// Where the border between the voxel after `n` more steps and the one after that is crossed.
    fn crossing(&self, axis: usize, n: u32) -> f64 {
        let steps = self.step[axis] as f64 * n as f64 + (self.step[axis] > 0) as i32 as f64;
        (self.key[axis] as f64 + steps - self.from[axis]) * self.inverse[axis]
    }

    fn find_next(&mut self) {
        for axis in 0..3 {
            let done = self.remaining[axis] == 0 && self.then_done[axis];
            self.t_next[axis] = if done { f64::INFINITY } else { self.crossing(axis, 0) };
        }
    }

    /// Skips to the first voxel in the block and ends the walk at the last.
    fn enter(mut self, min: VoxelKey, max: VoxelKey) -> Option<Self> {
        // The last crossing that brings the walk into the block's slabs.
        let mut last: Option<(f64, usize)> = None;
        for axis in 0..3 {
            let key = self.key[axis];
            let short = if self.step[axis] < 0 { key - max[axis] } else { min[axis] - key };
            if short > 0 && self.remaining[axis] < short as u32 {
                return None;
            }
            if short > 0 {
                let t = self.crossing(axis, short as u32 - 1);
                last = if last.is_none_or(|(t_last, _)| t >= t_last) { Some((t, axis)) } else { last };
            }
        }
        if let Some((t, axis)) = last {
            (0..3).for_each(|other| self.skip(other, t, other <= axis));
        }
        for axis in 0..3 {
            if self.key[axis] < min[axis] || self.key[axis] > max[axis] {
                return None;
            }
            let room =
                if self.step[axis] < 0 { self.key[axis] - min[axis] } else { max[axis] - self.key[axis] }
                    as u32;
            if room < self.remaining[axis] {
                (self.remaining[axis], self.then_done[axis]) = (room, false);
            }
        }
        self.find_next();
        Some(self)
    }

    /// Makes all steps along an axis that come before `t`, and at `t` if `also_at`.
    fn skip(&mut self, axis: usize, t: f64, also_at: bool) {
        let crossed = |walk: &Self, n: u32| {
            let at = walk.crossing(axis, n);
            at < t || (at == t && also_at)
        };
        let direction = 1.0 / self.inverse[axis];
        let reached = (self.from[axis] + direction * t).floor() - self.key[axis] as f64;
        let mut n = (reached.abs().min(u32::MAX as f64) as u32).min(self.remaining[axis]);
        while n > 0 && !crossed(self, n - 1) {
            n -= 1;
        }
        while n < self.remaining[axis] && crossed(self, n) {
            n += 1;
        }
        self.key[axis] += self.step[axis] * n as i32;
        if self.remaining[axis] != u32::MAX {
            self.remaining[axis] -= n;
        }
    }

    /// The voxel the walk is in.
    pub fn key(&self) -> VoxelKey {
        self.key
    }

    /// The direction of the steps along each axis: -1, 0 or 1.
    pub fn step(&self) -> IVec3 {
        self.step
    }

    /// Goes to the next voxel and tells the axis it moved along; none at the end.
    #[inline]
    pub fn advance(&mut self) -> Option<usize> {
        let [x, y, z] = self.t_next;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        if self.remaining[axis] == 0 {
            return None;
        }
        self.remaining[axis] -= 1;
        self.key[axis] += self.step[axis];
        let done = self.remaining[axis] == 0 && self.then_done[axis];
        self.t_next[axis] = if done { f64::INFINITY } else { self.crossing(axis, 0) };
        Some(axis)
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
            // Sampling may jump over a voxel that the segment only clips at a corner, but finds no other.
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
