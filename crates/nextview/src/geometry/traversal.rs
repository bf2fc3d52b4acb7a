use super::VoxelKey;
use glam::{DVec3, IVec3};

/// Walks all voxels that a straight segment crosses, in order, each once (Amanatides & Woo 1987).
///
/// The number of steps along each axis is fixed by the two end voxels, so that rounding can reorder two
/// crossings that happen at the same place but never make the walk miss its end. Crossings through an edge
/// or a corner go along the lower axis first.
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
/// assert_eq!(keys.first(), Some(&IVec3::new(0, 0, 0)));
/// assert_eq!(keys.last(), Some(&IVec3::new(2, 1, 0)));
/// ```
#[derive(Clone, Debug)]
pub struct SegmentWalk {
    key: VoxelKey,
    step: IVec3,
    /// Share of the segment at which the next voxel border of each axis is crossed; infinite once the axis is done.
    t_next: [f64; 3],
    t_delta: [f64; 3],
    remaining: [u32; 3],
}

impl SegmentWalk {
    /// A walk between two positions in units of voxels.
    pub fn new(from: DVec3, to: DVec3) -> Self {
        Self::between(from, from.floor().as_ivec3(), to, to.floor().as_ivec3())
    }

    /// A walk whose end voxels are given, for ends that were clipped to a border and may have been rounded
    /// to its other side.
    pub fn between(from: DVec3, from_key: VoxelKey, to: DVec3, to_key: VoxelKey) -> Self {
        let mut walk = Self {
            key: from_key,
            step: (to_key - from_key).signum(),
            t_next: [f64::INFINITY; 3],
            t_delta: [f64::INFINITY; 3],
            remaining: [0; 3],
        };
        for axis in 0..3 {
            walk.remaining[axis] = (to_key[axis] - from_key[axis]).unsigned_abs();
            if walk.remaining[axis] > 0 {
                let inverse = 1.0 / (to[axis] - from[axis]);
                let border = from_key[axis] + (walk.step[axis] > 0) as i32;
                walk.t_delta[axis] = inverse.abs();
                walk.t_next[axis] = (border as f64 - from[axis]) * inverse;
            }
        }
        walk
    }

    /// The voxel the walk is in.
    pub fn key(&self) -> VoxelKey {
        self.key
    }

    /// The direction of the steps along each axis: -1, 0 or 1.
    pub fn step(&self) -> IVec3 {
        self.step
    }

    /// Number of voxels still to come.
    pub fn n_remaining(&self) -> u32 {
        self.remaining.iter().sum()
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
        self.t_next[axis] =
            if self.remaining[axis] == 0 { f64::INFINITY } else { self.t_next[axis] + self.t_delta[axis] };
        Some(axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn keys(from: DVec3, to: DVec3) -> Vec<IVec3> {
        let mut walk = SegmentWalk::new(from, to);
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

    #[test]
    fn handles_points_axes_and_corners() {
        let origin = DVec3::splat(0.5);
        assert_eq!(keys(origin, origin), [IVec3::ZERO]);
        assert_eq!(keys(origin, DVec3::new(-1.5, 0.5, 0.5)).len(), 3);
        assert_eq!(keys(origin, DVec3::splat(2.5)).len(), 7, "through two corners, along the axes in turn");
        assert_eq!(keys(DVec3::ZERO, DVec3::new(0.0, 0.0, 2.0)).len(), 3, "along an edge, ends on borders");
    }
}
