use super::{Crossing, FreeSpace, Ray, RayEnd, RayGrid, Sight};
use crate::Error;
use crate::geometry::{Aabb, Pose, VoxelBlock};
use crate::map::{Occupancy, Snapshot};
use crate::sensor::Intrinsics;
use glam::{DVec3, IVec3};

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
/// caster.cast(&look_at(DVec3::X, DVec3::ZERO), |ray| {
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
    /// The box that rays are followed through, which holds all voxels that could change what a ray sees.
    bounds: Aabb,
    grid_of_passes: PassGrid,
    /// Visibility below which a ray ends.
    fade_limit: f32,
}

/// What passes through each voxel of a block, with a layer of [`OUTSIDE`](Self::OUTSIDE) around it: a ray then needs
/// no other test to find the end of the box.
#[derive(Debug)]
struct PassGrid {
    block: VoxelBlock,
    /// The block with the layer.
    padded: VoxelBlock,
    /// 1 - P(occupied) or 1 where free space is clear; 0 where a ray ends.
    passes: Vec<f32>,
}

impl<'a> RayCaster<'a> {
    /// A caster for a camera; `ray_spacing` is the distance between neighbouring rays at the far side of the box, in
    /// voxels, positive. [`NO_VOXEL_MISSED`](super::NO_VOXEL_MISSED) or less hits every voxel; 10 is as thin as the paper.
    ///
    /// `sight` may be a [`FreeSpace`] alone: rays then end where they have [faded](Sight::FADED).
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        ray_spacing: f64,
        sight: impl Into<Sight>,
    ) -> Result<Self, Error> {
        let Sight { free_space, fade_limit } = sight.into();
        if !(ray_spacing > 0.0 && ray_spacing.is_finite()) {
            return Err(Error::invalid("ray_spacing", ray_spacing, "a positive number of voxels"));
        }
        let block = match free_space {
            FreeSpace::Fades => snapshot.block(),
            FreeSpace::Clear => without_free_margin(snapshot),
        };
        Ok(Self {
            snapshot,
            grid: RayGrid::new(intrinsics),
            spacing: ray_spacing * snapshot.lattice().voxel_size(),
            bounds: snapshot.lattice().bounds(&block),
            grid_of_passes: PassGrid::new(snapshot, block, free_space),
            fade_limit,
        })
    }

    /// Casts the rays of a view, in a fixed order; those that miss the box are left out.
    pub fn cast(&self, world_from_camera: &Pose, mut visit: impl FnMut(Ray<'_>)) {
        let rotation = world_from_camera.rotation_matrix();
        let origin = self.snapshot.lattice().to_voxels(world_from_camera.translation());
        let mut crossings = Vec::new();
        for direction in self.grid.directions(world_from_camera, &self.bounds, self.spacing) {
            crossings.clear();
            if let Some(end) = self.trace(origin, rotation * direction, &mut crossings) {
                visit(Ray { crossings: &crossings, end });
            }
        }
    }

    /// Follows one ray, origin and direction in units of voxels; none if it misses the box.
    ///
    /// The same walk as [`SegmentWalk`](crate::geometry::SegmentWalk), cut down to what a ray needs: it takes half the
    /// time, and this loop is where planning spends its time.
    fn trace(&self, origin: DVec3, direction: DVec3, crossings: &mut Vec<Crossing>) -> Option<RayEnd> {
        let PassGrid { block, padded, passes } = &self.grid_of_passes;
        let (min, max) = (block.min().as_dvec3(), (block.max() + 1).as_dvec3());
        let (t_in, _) = Aabb { min, max }.clip(origin, direction, f64::INFINITY)?;
        // Cutting off the fraction is the floor here, without the call that a floor is on plain x86-64.
        let entry = min + (origin + direction * t_in - min).as_uvec3().min(block.dims() - 1).as_dvec3();
        let inverse = 1.0 / direction;
        let is_forward = direction.cmpgt(DVec3::ZERO);
        let border = entry + DVec3::select(is_forward, DVec3::ONE, DVec3::ZERO);
        let is_still = direction.cmpeq(DVec3::ZERO);
        let first = DVec3::select(is_still, DVec3::INFINITY, (border - origin) * inverse);
        let step = inverse.abs();
        let sign = |forward: bool, stride: usize| if forward { stride as isize } else { -(stride as isize) };
        let signed = |strides: [usize; 3]| std::array::from_fn(|i| sign(is_forward.test(i), strides[i]));
        let [index_x, index_y, index_z]: [isize; 3] = signed(padded.strides());
        let [voxel_x, voxel_y, voxel_z]: [isize; 3] = signed(self.snapshot.block().strides());
        let key = entry.as_ivec3();
        let (mut index, mut voxel) = (padded.index(key)?, self.snapshot.block().index(key)?);
        let (mut x, mut y, mut z) = (first.x, first.y, first.z);
        let mut visibility = 1.0_f32;
        loop {
            let pass = passes[index];
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
                x += step.x;
                index = index.wrapping_add_signed(index_x);
                voxel = voxel.wrapping_add_signed(voxel_x);
            } else if y <= z {
                y += step.y;
                index = index.wrapping_add_signed(index_y);
                voxel = voxel.wrapping_add_signed(voxel_y);
            } else {
                z += step.z;
                index = index.wrapping_add_signed(index_z);
                voxel = voxel.wrapping_add_signed(voxel_z);
            }
        }
    }
}

impl PassGrid {
    /// Marks the layer around the block.
    const OUTSIDE: f32 = -1.0;

    fn new(snapshot: &Snapshot, block: VoxelBlock, free_space: FreeSpace) -> Self {
        let padded = VoxelBlock::new(block.min() - 1, block.dims() + 2).expect("larger than a block");
        let pass = |index: usize| match (snapshot.occupancy()[index], free_space) {
            (Occupancy::Occupied, _) => 0.0,
            (Occupancy::Free, FreeSpace::Clear) => 1.0,
            _ => 1.0 - snapshot.probability()[index],
        };
        let inner = |key: IVec3| block.index(key).and_then(|_| snapshot.block().index(key));
        let passes =
            (0..padded.n_voxels()).map(|i| inner(padded.key(i)).map_or(Self::OUTSIDE, pass)).collect();
        Self { block, padded, passes }
    }
}

/// The smallest block that holds all voxels not known to be free (the whole one if there are none): clear free space
/// around it neither weakens a ray nor ends it.
fn without_free_margin(snapshot: &Snapshot) -> VoxelBlock {
    let block = snapshot.block();
    let is_free = |&index: &usize| snapshot.occupancy()[index] == Occupancy::Free;
    let keys = (0..block.n_voxels()).filter(|index| !is_free(index)).map(|index| block.key(index));
    let corners = keys.fold(None, |corners: Option<(IVec3, IVec3)>, key| {
        Some(corners.map_or((key, key), |(low, high)| (low.min(key), high.max(key))))
    });
    let inner = corners.and_then(|(low, high)| VoxelBlock::new(low, (high - low + 1).as_uvec3()));
    inner.unwrap_or(block)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, SegmentWalk};
    use crate::map::LogOdds;
    use crate::sensor::Distortion;
    use crate::view::look_at;
    use crate::visibility::NO_VOXEL_MISSED;
    use glam::{DVec2, UVec3};
    use proptest::prelude::*;

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
            let pose = look_at(position, DVec3::ZERO);
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

        /// The loop of its own crosses the voxels that the general walk crosses.
        #[test]
        fn rays_cross_the_voxels_of_the_walk(
            origin in prop::array::uniform3(-30.0..30.0), direction in prop::array::uniform3(-1.0..1.0),
            dims in prop::array::uniform3(1_u32..12),
        ) {
            let (origin, direction) = (DVec3::from_array(origin), DVec3::from_array(direction));
            let snapshot = snapshot(UVec3::from_array(dims), |_| Some(-20.0));
            let block = snapshot.block();
            let caster = RayCaster::new(&snapshot, &Intrinsics::d435i(), 1.0, FreeSpace::Fades).unwrap();
            let mut crossings = Vec::new();
            let end = caster.trace(origin, direction, &mut crossings);
            let mut expected = Vec::new();
            let walk = SegmentWalk::ray_within(origin, direction, block.min(), block.max());
            prop_assert_eq!(end, walk.as_ref().map(|_| RayEnd::LeftBox));
            if let Some(mut walk) = walk {
                expected.push(walk.key());
                while walk.advance().is_some() {
                    expected.push(walk.key());
                }
            }
            let found: Vec<IVec3> = crossings.iter().map(|c| block.key(c.voxel as usize)).collect();
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
            let pose = look_at(DVec3::new(x, y, z), DVec3::ZERO);
            let caster = RayCaster::new(&snapshot, &Intrinsics::d435i(), 2.0, FreeSpace::Fades).unwrap();
            let mut directions = caster.grid.directions(&pose, &caster.bounds, caster.spacing);
            let mut traced = Vec::new();
            caster.cast(&pose, |ray| traced.push((ray.crossings.to_vec(), ray.end)));
            let mut traced = traced.into_iter();
            let mut buffer = Vec::new();
            for direction in directions.by_ref() {
                let origin = snapshot.lattice().to_voxels(pose.translation());
                let direction = pose.rotation() * direction;
                if caster.trace(origin, direction, &mut buffer).is_some() {
                    let (crossings, end) = traced.next().expect("one ray per direction that meets the box");
                    check_by_sampling(&snapshot, origin, direction, &crossings, end)?;
                }
            }
            prop_assert!(traced.next().is_none());
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
        // Samples on a border, to rounding, say nothing about which side they are on.
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
        caster.cast(&look_at(DVec3::X, DVec3::X * 2.0), |_| n_rays += 1);
        assert_eq!(n_rays, 0);
        caster.cast(&look_at(DVec3::ZERO, DVec3::X), |ray| {
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
            let mut crossings = Vec::new();
            (caster.trace(origin, direction, &mut crossings), crossings.len())
        };
        // 0.5^10 < 1e-3, so the tenth unknown voxel is the last.
        assert_eq!(trace(FreeSpace::Clear.into()), (Some(RayEnd::Faded), 10));
        let last = Crossing { voxel: 0, visibility: 0.5_f32.powi(29) };
        assert_eq!(trace(Sight::endless(FreeSpace::Clear)), (Some(RayEnd::Occupied(last)), 29));
    }
}
