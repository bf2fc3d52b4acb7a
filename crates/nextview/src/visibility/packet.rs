use super::pass_grid::PassGrid;
use crate::geometry::lanes::{FIRST_INDEX, LANES, Lanes, abs, floor, load, store};
use crate::sensor::DepthRange;
use glam::DVec3;
use pulp::Simd;

/// Directions of the rays of a packet from the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    /// In units of voxels, along each axis.
    pub axes: [Lanes; 3],
    /// The lanes with a ray.
    pub is_ray: [bool; LANES],
}

/// Rays from one origin at their entry into a block, in units of voxels. They start a walk like
/// [`SegmentWalk`](crate::geometry::SegmentWalk), reduced to the needs of a ray.
///
/// Setting up a single short ray costs as much as following it; with eight at a time, a fifth of that.
#[derive(Debug, Default)]
pub(super) struct Packet {
    /// The cell in which the ray enters, as an [index](crate::geometry::lanes::cell); [`OUTSIDE`] if it
    /// misses the block.
    pub index: Lanes,
    pub axes: [PacketAxis; 3],
    /// Common origin of the rays.
    pub origin: DVec3,
    /// Along each axis; of length 1 in depth.
    pub directions: [Lanes; 3],
}

/// The part of a packet along one axis.
#[derive(Debug, Default)]
pub(super) struct PacketAxis {
    /// Where the ray next crosses a border of voxels, in lengths of its direction; infinite if never.
    pub next: Lanes,
    /// Distance between these borders.
    pub step: Lanes,
    /// Change of the index per step.
    pub stride: Lanes,
}

/// The index of a corner of every [`PassGrid`], which lies outside the block.
pub(super) const OUTSIDE: f64 = FIRST_INDEX;

impl Packet {
    /// Lets the parts of rays from `origin` that are within a range of depths, in voxels, into the block of a
    /// grid. A direction's length is that of a depth of 1.
    #[inline(always)]
    pub fn enter<S: Simd>(
        &mut self,
        simd: S,
        grid: &PassGrid,
        origin: DVec3,
        directions: &Directions,
        depths: DepthRange,
    ) {
        (self.origin, self.directions) = (origin, directions.axes);
        let mut is_ray = [0.0; LANES];
        #[allow(
            clippy::needless_range_loop,
            reason = "iterators are not always inlined into vector instructions"
        )]
        for lane in 0..LANES {
            is_ray[lane] = if directions.is_ray[lane] { 1.0 } else { 0.0 };
        }
        for part in 0..LANES / S::F64_LANES {
            let clip = Clip::new(simd, grid, origin, directions, depths, part);
            let mut index = simd.splat_f64s(OUTSIDE + grid.padded.strides().iter().sum::<usize>() as f64);
            for axis in 0..3 {
                let moved = self.enter_along(simd, axis, part, grid, origin[axis], &clip);
                index = simd.add_f64s(index, moved);
            }
            let is_ray = simd.greater_than_f64s(load::<S>(&is_ray, part), simd.splat_f64s(0.0));
            let enters = simd.and_m64s(is_ray, clip.meets);
            store::<S>(&mut self.index, part, simd.select_f64s(enters, index, simd.splat_f64s(OUTSIDE)));
        }
    }

    /// The direction of one of the rays.
    pub fn direction(&self, lane: usize) -> DVec3 {
        let [x, y, z] = &self.directions;
        DVec3::new(x[lane], y[lane], z[lane])
    }

    /// Fills one axis and returns the entry of the ray along it, in cells.
    #[inline(always)]
    fn enter_along<S: Simd>(
        &mut self,
        simd: S,
        axis: usize,
        part: usize,
        grid: &PassGrid,
        origin: f64,
        clip: &Clip<S>,
    ) -> S::f64s {
        let (min, dims) = (grid.block.min()[axis] as f64, grid.block.dims()[axis] as f64);
        let stride = grid.padded.strides()[axis] as f64;
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (origin, min, infinity) =
            (simd.splat_f64s(origin), simd.splat_f64s(min), simd.splat_f64s(f64::INFINITY));
        let (direction, inverse) = (clip.directions[axis], clip.inverses[axis]);
        let inside = simd.sub_f64s(simd.add_f64s(origin, simd.mul_f64s(direction, clip.t_in)), min);
        let entry = floor(simd, simd.min_f64s(simd.max_f64s(inside, zero), simd.splat_f64s(dims - 1.0)));
        let is_forward = simd.greater_than_f64s(direction, zero);
        let border = simd.add_f64s(simd.add_f64s(min, entry), simd.select_f64s(is_forward, one, zero));
        let next = simd.mul_f64s(simd.sub_f64s(border, origin), inverse);
        let signed = simd.select_f64s(is_forward, simd.splat_f64s(stride), simd.splat_f64s(-stride));
        let target = &mut self.axes[axis];
        store::<S>(&mut target.next, part, simd.select_f64s(clip.is_still[axis], infinity, next));
        store::<S>(&mut target.step, part, abs(simd, inverse));
        store::<S>(&mut target.stride, part, signed);
        simd.mul_f64s(entry, simd.splat_f64s(stride))
    }
}

/// [`Aabb::clip`](crate::geometry::Aabb::clip) within a range of depths, with selections instead of branches.
struct Clip<S: Simd> {
    directions: [S::f64s; 3],
    inverses: [S::f64s; 3],
    /// Whether the ray is parallel to the borders.
    is_still: [S::m64s; 3],
    /// Where it enters the block, or where the depths begin inside it, in lengths of its direction.
    t_in: S::f64s,
    meets: S::m64s,
}

impl<S: Simd> Clip<S> {
    #[inline(always)]
    fn new(
        simd: S,
        grid: &PassGrid,
        origin: DVec3,
        directions: &Directions,
        depths: DepthRange,
        part: usize,
    ) -> Self {
        let [x, y, z] = &directions.axes;
        let directions = [load::<S>(x, part), load::<S>(y, part), load::<S>(z, part)];
        let (zero, infinity) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
        let everywhere = simd.less_than_f64s(zero, infinity);
        let mut clip = Self {
            directions,
            inverses: directions,
            is_still: [everywhere; 3],
            t_in: simd.splat_f64s(depths.min),
            meets: everywhere,
        };
        let mut t_out = simd.splat_f64s(depths.max);
        for axis in 0..3 {
            let inverse = simd.div_f64s(simd.splat_f64s(1.0), directions[axis]);
            let is_still = simd.equal_f64s(abs(simd, inverse), infinity);
            let (min, origin) = (grid.block.min()[axis] as f64, origin[axis]);
            let max = min + grid.block.dims()[axis] as f64;
            let a = simd.mul_f64s(simd.splat_f64s(min - origin), inverse);
            let b = simd.mul_f64s(simd.splat_f64s(max - origin), inverse);
            let (low, high) = (simd.min_f64s(a, b), simd.max_f64s(a, b));
            clip.t_in = simd.select_f64s(is_still, clip.t_in, simd.max_f64s(clip.t_in, low));
            t_out = simd.select_f64s(is_still, t_out, simd.min_f64s(t_out, high));
            if origin < min || origin > max {
                clip.meets = simd.and_m64s(clip.meets, simd.not_m64s(is_still));
            }
            (clip.inverses[axis], clip.is_still[axis]) = (inverse, is_still);
        }
        clip.meets = simd.and_m64s(clip.meets, simd.less_than_or_equal_f64s(clip.t_in, t_out));
        clip
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::lanes::cell;
    use crate::geometry::{Aabb, Lattice, VoxelBlock};
    use crate::instructions::tests::archs;
    use crate::map::Snapshot;
    use crate::visibility::FreeSpace;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;
    use pulp::WithSimd;

    /// Fills a packet.
    pub struct Enter<'a> {
        pub packet: &'a mut Packet,
        pub grid: &'a PassGrid,
        pub origin: DVec3,
        pub directions: [DVec3; LANES],
        pub depths: DepthRange,
    }

    impl WithSimd for Enter<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let axes = [0, 1, 2].map(|axis| self.directions.map(|direction| direction[axis]));
            let directions = Directions { axes, is_ray: [true; LANES] };
            self.packet.enter(simd, self.grid, self.origin, &directions, self.depths);
        }
    }

    /// Positions and directions with many exact ties, including zeros and signed zeros.
    fn vector() -> impl Strategy<Value = DVec3> {
        let tied = prop::array::uniform3(-24..24).prop_map(|v| v.map(|x| x as f64 * 0.25));
        let signed = prop::array::uniform3(prop::sample::select(vec![-0.0, 0.0, 1.0, -2.0]));
        prop_oneof![prop::array::uniform3(-8.0..8.0), tied, signed].prop_map(DVec3::from_array)
    }

    proptest! {
        /// The slow twin: one ray by `Aabb::clip`, with branches.
        #[test]
        fn rays_enter_together_as_they_do_alone(
            origin in vector(), directions in prop::array::uniform8(vector()),
            min in prop::array::uniform3(-4..3), dims in prop::array::uniform3(1_u32..6),
            near in prop::sample::select(vec![0.0, 0.5, 3.0]), length in prop::sample::select(vec![0.25, 4.0, 1e9]),
        ) {
            let depths = DepthRange { min: near, max: near + length };
            let block = VoxelBlock::new(IVec3::from_array(min), UVec3::from_array(dims)).unwrap();
            let snapshot = Snapshot::from_fn(Lattice::new(1.0).unwrap(), block, |_| None);
            let grid = PassGrid::new(&snapshot, FreeSpace::Clear);
            let (min, max) = (block.min().as_dvec3(), (block.max() + 1).as_dvec3());
            for arch in archs() {
                let mut packet = Packet::default();
                arch.dispatch(Enter { packet: &mut packet, grid: &grid, origin, directions, depths });
                for (lane, &direction) in directions.iter().enumerate() {
                    let clip = Aabb { min, max }.clip(origin, direction, depths.max);
                    let Some(t_in) = clip.map(|(t_in, t_out)| (t_in.max(near), t_out)).filter(|(a, b)| a <= b) else {
                        prop_assert_eq!(packet.index[lane], OUTSIDE);
                        continue;
                    };
                    let (t_in, _) = t_in;
                    let entry = (origin + direction * t_in - min).as_uvec3().min(block.dims() - 1).as_ivec3();
                    prop_assert_eq!(Some(cell(packet.index[lane])), grid.padded.index(block.min() + entry));
                    for (i, axis) in packet.axes.iter().enumerate() {
                        let border = block.min()[i] + entry[i] + (direction[i] > 0.0) as i32;
                        let next = (border as f64 - origin[i]) * (1.0 / direction[i]);
                        let next = if direction[i] == 0.0 { f64::INFINITY } else { next };
                        let stride = grid.padded.strides()[i] as f64;
                        prop_assert_eq!(axis.next[lane].to_bits(), next.to_bits());
                        prop_assert_eq!(axis.step[lane].to_bits(), (1.0 / direction[i]).abs().to_bits());
                        prop_assert_eq!(axis.stride[lane], if direction[i] > 0.0 { stride } else { -stride });
                    }
                }
            }
        }
    }
}
