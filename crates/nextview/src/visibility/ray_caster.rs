use super::entries::{Entries, Tiles};
use super::packet::{Directions, Packet};
use super::pass_grid::PassGrid;
use super::ray_grid::Cells;
use super::{Crossing, MeasuredParts, Ray, RayEnd, RayGrid, Sight};
use crate::Error;
use crate::geometry::lanes::{LANES, cell};
use crate::geometry::{Aabb, Pose};
use crate::instructions::instructions;
use crate::map::Snapshot;
use crate::sensor::{DepthRange, Intrinsics};
use glam::{DMat3, DVec3};
use pulp::{Arch, Simd, WithSimd};
use std::convert::Infallible;

/// Sends the rays of view candidates through a snapshot, voxel by voxel (exact traversal).
///
/// ```
/// use glam::{DVec3, IVec3, UVec3};
/// use nextview::geometry::{Lattice, VoxelBlock};
/// use nextview::map::Snapshot;
/// use nextview::sensor::Intrinsics;
/// use nextview::view::look_at;
/// use nextview::visibility::{FreeSpace, NO_VOXEL_MISSED, RayCaster};
///
/// let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
/// let unknown = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
/// let caster = RayCaster::new(&unknown, &Intrinsics::d435i(), NO_VOXEL_MISSED, FreeSpace::Clear).unwrap();
/// let mut first_visibility = None;
/// caster.cast(&look_at(DVec3::X, DVec3::ZERO).unwrap(), |ray| {
///     first_visibility = ray.crossings.first().map(|crossing| crossing.visibility);
/// });
/// assert_eq!(first_visibility, Some(1.0));
/// ```
#[derive(Debug)]
pub struct RayCaster<'a> {
    snapshot: &'a Snapshot,
    grid: RayGrid,
    /// Distance between rays at the far side of the box, metres.
    spacing: f64,
    /// The box in which rays are followed.
    bounds: Aabb,
    pub(super) passes: PassGrid,
    /// Visibility below which a ray ends.
    pub(super) fade_limit: f32,
    /// The depths that the camera measures, in voxels.
    depths: DepthRange,
    /// The instruction set of the CPU.
    pub(super) arch: Arch,
}

impl<'a> RayCaster<'a> {
    /// Creates a caster for a camera; `ray_spacing` is the distance between neighbouring rays at the far side
    /// of the box, in voxels, positive. [`NO_VOXEL_MISSED`](super::NO_VOXEL_MISSED) or less hits every voxel;
    /// 10 is as sparse as in the paper.
    ///
    /// `sight` may be a [`FreeSpace`](super::FreeSpace) alone: rays then end where they have
    /// [faded](Sight::FADED).
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        ray_spacing: f64,
        sight: impl Into<Sight>,
    ) -> Result<Self, Error> {
        let Sight { free_space, fade_limit } = sight.into();
        Self::with_passes(snapshot, intrinsics, ray_spacing, PassGrid::new(snapshot, free_space), fade_limit)
    }

    /// Creates a caster for voxels that pass on these shares of visibility, above 0 and up to 1, one for each
    /// voxel of the snapshot.
    pub(crate) fn through(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        ray_spacing: f64,
        passes: &[f32],
        fade_limit: f32,
    ) -> Result<Self, Error> {
        Self::with_passes(
            snapshot,
            intrinsics,
            ray_spacing,
            PassGrid::of_passes(snapshot, passes),
            fade_limit,
        )
    }

    fn with_passes(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        ray_spacing: f64,
        passes: PassGrid,
        fade_limit: f32,
    ) -> Result<Self, Error> {
        if !(ray_spacing > 0.0 && ray_spacing.is_finite()) {
            return Err(Error::invalid("ray_spacing", ray_spacing, "a positive number of voxels"));
        }
        Ok(Self {
            snapshot,
            grid: RayGrid::new(intrinsics),
            spacing: ray_spacing * snapshot.lattice().voxel_size(),
            bounds: snapshot.lattice().bounds(&passes.block),
            passes,
            fade_limit,
            depths: DepthRange::default(),
            arch: instructions(),
        })
    }

    /// Sets the depths that the camera measures: rays begin at the least of them, and those that enter the
    /// box beyond the largest are left out.
    pub fn within(self, range: DepthRange) -> Self {
        let in_voxels = |depth: f64| depth / self.snapshot.lattice().voxel_size();
        Self { depths: DepthRange { min: in_voxels(range.min), max: in_voxels(range.max) }, ..self }
    }

    /// Makes rays end at the measured parts of occupied voxels and continue next to them.
    pub(crate) fn behind(self, measured: &MeasuredParts) -> Self {
        Self { passes: self.passes.behind(measured, self.snapshot), ..self }
    }

    /// Casts the rays of a view, in a fixed order; those that miss the box are left out.
    pub fn cast(&self, world_from_camera: &Pose, mut visit: impl FnMut(Ray<'_>)) {
        let Ok(()) = self.try_cast(world_from_camera, |ray| {
            visit(ray);
            Ok::<(), Infallible>(())
        });
    }

    /// As [`cast`](Self::cast), but stops at the first ray for which `visit` fails.
    pub fn try_cast<E>(
        &self,
        world_from_camera: &Pose,
        mut visit: impl FnMut(Ray<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut crossings = Vec::new();
        self.try_for_each_packet(world_from_camera, None, |packet| {
            for lane in 0..LANES {
                crossings.clear();
                if let Some(end) = self.trace(packet, lane, &mut crossings) {
                    visit(Ray { crossings: &crossings, end })?;
                }
            }
            Ok(())
        })
    }

    /// Visits the rays of a view at their entry into the box, [`LANES`] at a time and in order. Stops when
    /// `visit` fails. With `entries`, rays that pass none of them may be left out.
    pub(super) fn try_for_each_packet<E>(
        &self,
        world_from_camera: &Pose,
        entries: Option<&Entries>,
        mut visit: impl FnMut(&Packet) -> Result<(), E>,
    ) -> Result<(), E> {
        let rotation = world_from_camera.rotation_matrix();
        let origin = self.snapshot.lattice().to_voxels(world_from_camera.translation());
        let cells = &self.grid.cells(world_from_camera, &self.bounds, self.spacing);
        let tiles = entries.and_then(|entries| {
            entries.seen_from(self.arch, &rotation, origin, self.depths.min, cells.len())
        });
        let (mut packet, mut rays) = (Packet::default(), PlaneRays::default());
        for start in (0..cells.len()).step_by(SHARE) {
            let (grid, tiles) = (&self.grid, tiles.as_ref());
            self.arch.dispatch(Collect { rays: &mut rays, grid, cells, start, tiles });
            for first in (0..rays.len).step_by(LANES) {
                let (packet, rays) = (&mut packet, &rays);
                self.arch.dispatch(Prepare { packet, caster: self, rays, first, rotation, origin });
                visit(packet)?;
            }
        }
        Ok(())
    }

    /// Follows one ray of a packet; `None` if it misses the box.
    fn trace(&self, packet: &Packet, lane: usize, crossings: &mut Vec<Crossing>) -> Option<RayEnd> {
        let PassGrid { block, padded, passes, .. } = &self.passes;
        let mut index = cell(packet.index[lane]);
        let key = padded.key(index);
        block.index(key)?;
        let mut voxel = self.snapshot.block().index(key)?;
        let [x, y, z] = &packet.axes;
        let [index_x, index_y, index_z] = [x, y, z].map(|axis| axis.stride[lane] as isize);
        let [stride_x, stride_y, stride_z] = self.snapshot.block().strides().map(|stride| stride as isize);
        let [voxel_x, voxel_y, voxel_z] =
            [stride_x * index_x.signum(), stride_y * index_y.signum(), stride_z * index_z.signum()];
        let [step_x, step_y, step_z] = [x.step[lane], y.step[lane], z.step[lane]];
        let (mut x, mut y, mut z) = (x.next[lane], y.next[lane], z.next[lane]);
        let mut visibility = 1.0_f32;
        loop {
            let pass = match passes[index] {
                pass if pass < PassGrid::OUTSIDE => {
                    self.passes.beside(index, packet.origin, packet.direction(lane))
                }
                pass => pass,
            };
            let crossing = Crossing { voxel: voxel as u32, visibility };
            if pass <= 0.0 {
                return Some(if pass == 0.0 { RayEnd::Occupied(crossing) } else { RayEnd::LeftBox });
            }
            crossings.push(crossing);
            visibility *= pass;
            if visibility < self.fade_limit {
                return Some(RayEnd::Faded);
            }
            if x <= y && x <= z {
                x += step_x;
                index = index.wrapping_add_signed(index_x);
                voxel = voxel.wrapping_add_signed(voxel_x);
            } else if y <= z {
                y += step_y;
                index = index.wrapping_add_signed(index_y);
                voxel = voxel.wrapping_add_signed(voxel_y);
            } else {
                z += step_z;
                index = index.wrapping_add_signed(index_z);
                voxel = voxel.wrapping_add_signed(voxel_z);
            }
        }
    }
}

/// Number of cells of an image whose rays are collected at a time.
const SHARE: usize = 512;

/// Rays of a view, by their places on the plane z = 1.
struct PlaneRays {
    x: [f64; SHARE + LANES],
    y: [f64; SHARE + LANES],
    len: usize,
}

impl Default for PlaneRays {
    fn default() -> Self {
        Self { x: [0.0; SHARE + LANES], y: [0.0; SHARE + LANES], len: 0 }
    }
}

/// Collects the rays through the cells of an image from `start` on; with tiles, only those that pass them.
struct Collect<'a> {
    rays: &'a mut PlaneRays,
    grid: &'a RayGrid,
    cells: &'a Cells,
    start: usize,
    tiles: Option<&'a Tiles>,
}

impl WithSimd for Collect<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut len = 0;
        for start in (self.start..self.cells.len().min(self.start + SHARE)).step_by(LANES) {
            let ideal = self.grid.ideal(self.cells, start);
            let shown = if let Some(tiles) = self.tiles { tiles.show(&ideal) } else { [true; LANES] };
            #[allow(
                clippy::needless_range_loop,
                reason = "iterators are not always inlined into vector instructions"
            )]
            for lane in 0..LANES {
                (self.rays.x[len], self.rays.y[len]) = (ideal.x[lane], ideal.y[lane]);
                len += usize::from(ideal.is_known[lane] && shown[lane]);
            }
        }
        self.rays.len = len;
    }
}

/// Prepares the collected rays from `first` on.
struct Prepare<'a> {
    packet: &'a mut Packet,
    caster: &'a RayCaster<'a>,
    rays: &'a PlaneRays,
    first: usize,
    rotation: DMat3,
    /// In units of voxels.
    origin: DVec3,
}

impl WithSimd for Prepare<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut axes = [[0.0; LANES]; 3];
        let mut is_ray = [false; LANES];
        for lane in 0..LANES {
            let ray = self.first + lane;
            let direction = self.rotation * DVec3::new(self.rays.x[ray], self.rays.y[ray], 1.0);
            (axes[0][lane], axes[1][lane], axes[2][lane]) = (direction.x, direction.y, direction.z);
            is_ray[lane] = ray < self.rays.len;
        }
        let directions = Directions { axes, is_ray };
        self.packet.enter(simd, &self.caster.passes, self.origin, &directions, self.caster.depths);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, SegmentWalk, VoxelBlock};
    use crate::map::{LogOdds, Occupancy};
    use crate::sensor::Distortion;
    use crate::view::look_at;
    use crate::visibility::measured_parts::meets;
    use crate::visibility::packet::tests::Enter;
    use crate::visibility::{FreeSpace, NO_VOXEL_MISSED};
    use glam::{DVec2, IVec3, UVec3};
    use proptest::prelude::*;

    /// Traces one ray, origin and direction in units of voxels; `None` if it misses the box.
    fn trace(caster: &RayCaster<'_>, origin: DVec3, direction: DVec3) -> Option<(Vec<Crossing>, RayEnd)> {
        let (mut packet, grid, directions) = (Packet::default(), &caster.passes, [direction; LANES]);
        caster.arch.dispatch(Enter { packet: &mut packet, grid, origin, directions, depths: caster.depths });
        let mut crossings = Vec::new();
        caster.trace(&packet, 3, &mut crossings).map(|end| (crossings, end))
    }

    fn snapshot(dims: UVec3, state: impl Fn(usize) -> Option<f32>) -> Snapshot {
        let block = VoxelBlock::new(-(dims / 2).as_ivec3(), dims).unwrap();
        let log_odds = |key| state(block.index(key).unwrap()).map(LogOdds);
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, log_odds)
    }

    fn cameras() -> Vec<Intrinsics> {
        let pinhole = Intrinsics::pinhole(320, 240, DVec2::splat(300.0), DVec2::new(160.0, 120.0)).unwrap();
        let barrel =
            pinhole.with_distortion(Distortion::BrownConrady([-0.2, 0.03, 0.001, 0.002, 0.0])).unwrap();
        vec![pinhole, barrel, Intrinsics::d435i()]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// In an empty box, every voxel whose centre the image shows with its inscribed ball is crossed.
        #[test]
        fn no_voxel_is_missed(x in -0.5..0.5, y in -0.5..0.5, z in -0.5..0.5, dims in prop::array::uniform3(3_u32..14), camera in 0_usize..3) {
            let position = DVec3::new(x, y, z);
            let snapshot = snapshot(UVec3::from_array(dims), |_| Some(-20.0));
            let intrinsics = cameras()[camera];
            let pose = look_at(position, DVec3::ZERO).unwrap();
            let mut seen = vec![false; snapshot.block().n_voxels()];
            let caster = RayCaster::new(&snapshot, &intrinsics, NO_VOXEL_MISSED, FreeSpace::Fades).unwrap();
            caster.cast(&pose, |ray| ray.crossings.iter().for_each(|c| seen[c.voxel as usize] = true));
            for (index, &seen) in seen.iter().enumerate() {
                let center = pose.inverse().transform_point(snapshot.lattice().center(snapshot.block().key(index)));
                let radius_px = 0.6 * 0.01 * 620.0 / center.z;
                let inside = center.z > 0.02 && intrinsics.project(center).is_some_and(|pixel| {
                    [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].iter().all(|d| intrinsics.contains(pixel + *d * radius_px))
                });
                prop_assert!(seen || !inside, "voxel {index} of {dims:?} missed from {position}");
            }
        }

        /// The dedicated loop crosses the voxels that the general walk crosses.
        #[test]
        fn rays_cross_the_voxels_of_the_walk(
            origin in prop::array::uniform3(-30.0..30.0), direction in prop::array::uniform3(-1.0..1.0),
            dims in prop::array::uniform3(1_u32..12),
        ) {
            let (origin, direction) = (DVec3::from_array(origin), DVec3::from_array(direction));
            let snapshot = snapshot(UVec3::from_array(dims), |_| Some(-20.0));
            let block = snapshot.block();
            let caster = RayCaster::new(&snapshot, &Intrinsics::d435i(), 1.0, FreeSpace::Fades).unwrap();
            let (crossings, end) = trace(&caster, origin, direction).unzip();
            let mut expected = Vec::new();
            let walk = SegmentWalk::ray_within(origin, direction, block.min(), block.max());
            prop_assert_eq!(end, walk.as_ref().map(|_| RayEnd::LeftBox));
            if let Some(mut walk) = walk {
                expected.push(walk.key());
                while walk.advance().is_some() {
                    expected.push(walk.key());
                }
            }
            let found: Vec<IVec3> = crossings.unwrap_or_default().iter().map(|c| block.key(c.voxel as usize)).collect();
            prop_assert_eq!(found, expected);
        }

        /// Visibility equals the product over the voxels before, by fine sampling along the ray.
        #[test]
        fn rays_agree_with_fine_sampling(states in prop::collection::vec(0_u8..8, 6 * 6 * 6), x in 0.1..0.4, y in -0.4..0.4, z in -0.4..0.4) {
            let snapshot = snapshot(UVec3::splat(6), |i| match states[i] {
                0..=2 => None,
                3 => Some(0.85),
                n => Some(-0.3 * n as f32),
            });
            let pose = look_at(DVec3::new(x, y, z), DVec3::ZERO).unwrap();
            let caster = RayCaster::new(&snapshot, &Intrinsics::d435i(), 2.0, FreeSpace::Fades).unwrap();
            let mut directions = caster.grid.directions(&pose, &caster.bounds, caster.spacing);
            let mut traced = Vec::new();
            caster.cast(&pose, |ray| traced.push((ray.crossings.to_vec(), ray.end)));
            let mut traced = traced.into_iter();
            for direction in directions.by_ref() {
                let origin = snapshot.lattice().to_voxels(pose.translation());
                let direction = pose.rotation() * direction;
                if trace(&caster, origin, direction).is_some() {
                    let (crossings, end) = traced.next().expect("one ray per direction that meets the box");
                    check_by_sampling(&snapshot, origin, direction, &crossings, end)?;
                }
            }
            prop_assert!(traced.next().is_none());
        }
    }

    proptest! {
        /// The slow twin: the walk in whole voxels, up to the first occupied one with a part that it meets.
        #[test]
        fn rays_end_at_measured_parts(
            origin in prop::array::uniform3(-30.0..30.0), direction in prop::array::uniform3(-1.0..1.0),
            dims in prop::array::uniform3(1_u32..9), drawn in prop::collection::vec((0_usize..4, any::<u64>(), any::<u64>()), 512),
        ) {
            let (origin, direction) = (DVec3::from_array(origin), DVec3::from_array(direction));
            let snapshot = snapshot(UVec3::from_array(dims), |i| [None, Some(0.85), Some(0.85), Some(-0.4)][drawn[i].0]);
            let block = snapshot.block();
            let parts: Vec<u64> = drawn.iter().map(|(_, a, b)| a & b).take(block.n_voxels()).collect();
            let measured = MeasuredParts::of_parts(block, parts.clone());
            let passes = vec![0.95; block.n_voxels()];
            let whole = RayCaster::through(&snapshot, &Intrinsics::d435i(), 1.0, &passes, 0.03).unwrap();
            let expected = trace(&whole, origin, direction).map(|(crossings, end)| {
                let ends = |crossing: &Crossing| {
                    let voxel = crossing.voxel as usize;
                    snapshot.occupancy()[voxel] == Occupancy::Occupied
                        && meets(parts[voxel], block.key(voxel), origin, direction)
                };
                match crossings.iter().position(ends) {
                    Some(n) => (crossings[..n].to_vec(), RayEnd::Occupied(crossings[n])),
                    None => (crossings, end),
                }
            });
            prop_assert_eq!(trace(&whole.behind(&measured), origin, direction), expected);
        }

        /// The slow twin: the general walk and a product, from the first voxel that weakens any ray.
        #[test]
        fn rays_go_through_what_passes_are_given(
            origin in prop::array::uniform3(-30.0..30.0), direction in prop::array::uniform3(-1.0..1.0),
            dims in prop::array::uniform3(1_u32..9), fade_limit in prop::sample::select(vec![0.0_f32, 0.03, 0.4]),
            drawn in prop::collection::vec(prop_oneof![Just(1.0), (0.001..0.999).prop_map(|pass| pass as f32)], 512),
        ) {
            let (origin, direction) = (DVec3::from_array(origin), DVec3::from_array(direction));
            let snapshot = snapshot(UVec3::from_array(dims), |i| [None, Some(0.85), Some(-0.4)][i % 3]);
            let passes = &drawn[..snapshot.block().n_voxels()];
            let caster = RayCaster::through(&snapshot, &Intrinsics::d435i(), 1.0, passes, fade_limit).unwrap();
            let inner = caster.passes.block;
            let (mut expected, mut visibility) = (Vec::new(), 1.0);
            let mut walk = SegmentWalk::ray_within(origin, direction, inner.min(), inner.max());
            while let Some(at) = walk.take() {
                let voxel = snapshot.block().index(at.key()).unwrap();
                expected.push(Crossing { voxel: voxel as u32, visibility });
                visibility *= passes[voxel];
                let mut next = at;
                walk = if visibility < fade_limit { None } else { next.advance().map(|_| next) };
            }
            let end = if visibility < fade_limit { RayEnd::Faded } else { RayEnd::LeftBox };
            let expected = (!expected.is_empty()).then_some((expected, end));
            prop_assert_eq!(trace(&caster, origin, direction), expected);
        }
    }

    fn check_by_sampling(
        snapshot: &Snapshot,
        origin: DVec3,
        direction: DVec3,
        crossings: &[Crossing],
        end: RayEnd,
    ) -> Result<(), TestCaseError> {
        let block = snapshot.block();
        let span = |voxel: u32| {
            let min = block.key(voxel as usize).as_dvec3() - 1e-9;
            Aabb { min, max: min + 1.0 + 2e-9 }.clip(origin, direction, f64::INFINITY)
        };
        let t_end = match end {
            RayEnd::Occupied(last) => span(last.voxel).map(|(t_in, _)| t_in),
            RayEnd::Faded => crossings.last().and_then(|last| span(last.voxel)).map(|(_, t_out)| t_out),
            RayEnd::LeftBox => Some(60.0),
        };
        prop_assert!(
            t_end.is_some() && crossings.iter().all(|c| span(c.voxel).is_some()),
            "a voxel off the ray"
        );
        // Samples on a border, to rounding, do not show which side they are on.
        let clear = |p: &DVec3| (*p - p.round()).abs().min_element() > 1e-8;
        let n_samples = (t_end.unwrap_or(0.0) * 1e3) as usize;
        let samples = (0..n_samples).map(|i| origin + direction * (i as f64 * 1e-3)).filter(clear);
        let mut sampled: Vec<usize> = samples.filter_map(|p| block.index(p.floor().as_ivec3())).collect();
        sampled.dedup();
        let mut rest = crossings.iter();
        for voxel in sampled {
            prop_assert!(rest.any(|c| c.voxel as usize == voxel), "voxel {voxel} missed");
            prop_assert!(snapshot.occupancy()[voxel] != Occupancy::Occupied);
        }
        let mut visibility = 1.0_f32;
        for crossing in crossings {
            prop_assert_eq!(crossing.visibility, visibility);
            visibility *= 1.0 - snapshot.probability()[crossing.voxel as usize];
        }
        if let RayEnd::Occupied(last) = end {
            prop_assert_eq!(last.visibility, visibility);
        }
        Ok(())
    }

    #[test]
    fn a_box_behind_the_camera_gets_no_rays() {
        let snapshot = snapshot(UVec3::splat(4), |_| None);
        let caster = RayCaster::new(&snapshot, &Intrinsics::d435i(), 1.0, FreeSpace::Clear).unwrap();
        let mut n_rays = 0;
        caster.cast(&look_at(DVec3::X, DVec3::X * 2.0).unwrap(), |_| n_rays += 1);
        assert_eq!(n_rays, 0);
        caster.cast(&look_at(DVec3::ZERO, DVec3::X).unwrap(), |ray| {
            n_rays += 1;
            assert!(!ray.crossings.is_empty());
        });
        assert!(n_rays > 0, "a camera inside the box sees what is before it");
        assert!(RayCaster::new(&snapshot, &Intrinsics::d435i(), 0.0, FreeSpace::Clear).is_err());
    }

    #[test]
    fn rays_without_a_limit_go_on_where_others_have_faded() {
        let snapshot = snapshot(UVec3::new(30, 1, 1), |i| (i == 0).then_some(0.85));
        let (origin, direction) = (DVec3::new(20.0, 0.5, 0.5), DVec3::NEG_X);
        let trace = |sight: Sight| {
            let caster = RayCaster::new(&snapshot, &Intrinsics::d435i(), 1.0, sight).unwrap();
            trace(&caster, origin, direction).map(|(crossings, end)| (end, crossings.len())).unwrap()
        };
        // 0.5^10 < 1e-3, so the tenth unknown voxel is the last.
        assert_eq!(trace(FreeSpace::Clear.into()), (RayEnd::Faded, 10));
        let last = Crossing { voxel: 0, visibility: 0.5_f32.powi(29) };
        assert_eq!(trace(Sight::endless(FreeSpace::Clear)), (RayEnd::Occupied(last), 29));
    }
}
