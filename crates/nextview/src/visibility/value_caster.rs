use super::entries::Entries;
use super::packet::Packet;
use super::paths::Paths;
use super::{RayCaster, pass_grid::PassGrid};
use crate::geometry::Pose;
use crate::geometry::lanes::LANES;
use crate::map::Snapshot;
use pulp::{Simd, WithSimd};
use std::convert::Infallible;

/// Casts rays for planners that need only the voxels of positive value that a ray crosses, and their
/// visibility.
///
/// It reports these as [`RayCaster::cast`] does, in the same order, in a fraction of the time: other voxels
/// and rays that nothing weakens are left out, and the rays are walked side by side.
#[derive(Debug)]
pub(crate) struct ValueCaster<'a> {
    caster: RayCaster<'a>,
    /// `None` if they would leave out no ray.
    entries: Option<Entries>,
    /// By cell; [`NO_ITEM`] for cells of no value.
    items: Vec<u32>,
    /// By item.
    value: Vec<f64>,
}

const NO_ITEM: u32 = u32::MAX;

impl<'a> ValueCaster<'a> {
    /// Numbers the voxels of positive value, all of which must weaken a ray, as items, in the order of the
    /// voxels.
    pub fn new(caster: RayCaster<'a>, snapshot: &Snapshot, value_of_voxel: &[f64]) -> Self {
        let mut items = vec![NO_ITEM; caster.passes.padded.n_voxels()];
        let mut value = Vec::new();
        for (cells, voxels) in caster.passes.rows(snapshot) {
            for (cell, voxel) in cells.zip(voxels) {
                if value_of_voxel[voxel] > 0.0 {
                    items[cell] = value.len() as u32;
                    value.push(value_of_voxel[voxel]);
                }
            }
        }
        Self { entries: Entries::of(&caster.passes), caster, items, value }
    }

    /// Number of items.
    pub fn n_items(&self) -> usize {
        self.value.len()
    }

    /// Allocates the paths of rays, reusable from view to view.
    pub fn paths(&self) -> Paths {
        Paths::new(&self.caster.passes)
    }

    /// Visits all items that the rays of a view cross, ray by ray, with their quality, which is value times
    /// visibility; returns the sum of the qualities in this order.
    pub fn cast(&self, world_from_camera: &Pose, paths: &mut Paths, visit: impl FnMut(usize, f64)) -> f64 {
        let Ok(sum) = self.cast_while(world_from_camera, paths, || Ok::<(), Infallible>(()), visit);
        sum
    }

    /// As [`cast`](Self::cast), but stops before the first rays for which `go_on` fails.
    pub fn cast_while<E>(
        &self,
        world_from_camera: &Pose,
        paths: &mut Paths,
        go_on: impl Fn() -> Result<(), E>,
        mut visit: impl FnMut(usize, f64),
    ) -> Result<f64, E> {
        let mut sum = 0.0;
        go_on()?;
        self.caster.try_for_each_packet(world_from_camera, self.entries.as_ref(), |packet| {
            go_on()?;
            let (grid, fade_limit) = (&self.caster.passes, self.caster.fade_limit);
            self.caster.arch.dispatch(Follow { paths: &mut *paths, packet, grid, fade_limit });
            // In a register: in memory, each addition would wait twelve cycles for the one before.
            let mut running_sum = sum;
            for lane in 0..LANES {
                for (cell, visibility) in paths.weakened(lane) {
                    let item = self.items[cell];
                    if item != NO_ITEM {
                        let quality = self.value[item as usize] * visibility as f64;
                        running_sum += quality;
                        visit(item as usize, quality);
                    }
                }
            }
            sum = running_sum;
            Ok(())
        })?;
        Ok(sum)
    }
}

/// Arguments of [`Paths::follow`].
struct Follow<'a> {
    paths: &'a mut Paths,
    packet: &'a Packet,
    grid: &'a PassGrid,
    fade_limit: f32,
}

impl WithSimd for Follow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.paths.follow(simd, self.packet, self.grid, self.fade_limit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::instructions::tests::archs;
    use crate::map::{LogOdds, Occupancy};
    use crate::sensor::{DepthRange, Distortion, Intrinsics};
    use crate::view::look_at;
    use crate::visibility::{FreeSpace, MeasuredParts, Sight};
    use glam::{DVec2, DVec3, IVec3, UVec3};
    use proptest::prelude::*;

    fn cameras() -> Vec<Intrinsics> {
        let pinhole = Intrinsics::pinhole(320, 240, DVec2::splat(300.0), DVec2::new(160.0, 120.0)).unwrap();
        let barrel =
            pinhole.with_distortion(Distortion::BrownConrady([-0.2, 0.03, 0.001, 0.002, 0.0])).unwrap();
        vec![pinhole, barrel, Intrinsics::d435i()]
    }

    /// Boxes that are three quarters free: rays then end in many ways.
    fn states() -> impl Strategy<Value = Vec<Option<f32>>> {
        let state = prop_oneof![1 => Just(None), 1 => Just(Some(0.85)), 6 => (1..5).prop_map(|n| Some(-0.4 * n as f32))];
        prop::collection::vec(state, 11 * 9 * 10)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        /// The slow twin: all crossings of all rays.
        #[test]
        fn tells_what_a_cast_of_single_rays_tells(
            states in states(), position in prop::array::uniform3(-0.4..0.4), camera in 0_usize..3,
            free_space in prop::sample::select(vec![FreeSpace::Clear, FreeSpace::Fades]),
            fade_limit in prop::sample::select(vec![0.0, Sight::FADED, 0.2]), spacing in 0.5..6.0,
        ) {
            let (snapshot, sight) = (snapshot(&states), Sight { free_space, fade_limit });
            let has_value = |i: usize| states[i].is_none() && !i.is_multiple_of(5);
            let value: Vec<f64> = (0..states.len()).map(|i| if has_value(i) { 1.0 / i as f64 } else { 0.0 }).collect();
            let caster = || RayCaster::new(&snapshot, &cameras()[camera], spacing, sight).unwrap();
            check(caster, &snapshot, &value, &look_at(DVec3::from_array(position), DVec3::ZERO).unwrap())?;
        }

        /// As above, but with given shares of visibility: rays then go through occupied voxels, and free ones
        /// may have value.
        #[test]
        fn tells_what_single_rays_through_given_passes_tell(
            states in states(), position in prop::array::uniform3(-0.4..0.4), camera in 0_usize..3,
            fade_limit in prop::sample::select(vec![0.0_f32, 0.03]), spacing in 0.5..6.0,
        ) {
            let snapshot = snapshot(&states);
            let pass = |i: usize| match states[i] {
                None => 0.6,
                Some(log_odds) if log_odds > 0.0 => 0.25,
                Some(_) => if i.is_multiple_of(5) { 0.95 } else { 1.0 },
            };
            let passes: Vec<f32> = (0..states.len()).map(pass).collect();
            let value: Vec<f64> = passes.iter().map(|&pass| if pass == 0.25 || pass == 1.0 { 0.0 } else { 1.0 }).collect();
            let caster = || RayCaster::through(&snapshot, &cameras()[camera], spacing, &passes, fade_limit).unwrap();
            check(caster, &snapshot, &value, &look_at(DVec3::from_array(position), DVec3::ZERO).unwrap())?;
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// As above, but measured parts end rays.
        #[test]
        fn tells_what_single_rays_up_to_measured_parts_tell(
            states in states(), parts in prop::collection::vec(prop_oneof![2 => Just(0_u64), 1 => any::<u64>()], 11 * 9 * 10),
            position in prop::array::uniform3(-0.4..0.4), spacing in 0.5..6.0,
        ) {
            let snapshot = snapshot(&states);
            let measured = MeasuredParts::of_parts(snapshot.block(), parts);
            let pass = |state: &Option<f32>| state.map_or(0.6, |log_odds| if log_odds > 0.0 { 0.95 } else { 1.0 });
            let passes: Vec<f32> = states.iter().map(pass).collect();
            let value: Vec<f64> = states.iter().map(|state| f64::from(u8::from(state.is_none()))).collect();
            let caster = || {
                RayCaster::through(&snapshot, &Intrinsics::d435i(), spacing, &passes, 0.03).unwrap().behind(&measured)
            };
            check(caster, &snapshot, &value, &look_at(DVec3::from_array(position), DVec3::ZERO).unwrap())?;
        }
    }

    proptest! {
        /// As above, but in a large box, clear except for a few bodies: most rays are then left out.
        #[test]
        fn tells_what_single_rays_among_few_bodies_tell(
            bodies in prop::collection::vec((prop::array::uniform3(0_i32..36), 1_i32..9, 0_u8..3), 1..5),
            position in prop::array::uniform3(-0.7..0.7), camera in 0_usize..3, spacing in 0.5..6.0, near in 0.0..0.3,
        ) {
            let block = VoxelBlock::new(IVec3::new(-20, -18, -17), UVec3::new(40, 36, 34)).unwrap();
            let state = |key: IVec3| {
                let place = key - block.min();
                let body = bodies.iter().find(|(at, size, _)| {
                    let inside = place - IVec3::from_array(*at);
                    inside.min_element() >= 0 && inside.max_element() < *size
                });
                match body {
                    None => Some(LogOdds(-0.4)),
                    Some((.., 0)) => Some(LogOdds(0.85)),
                    Some((at, ..)) if place.x == at[0] => Some(LogOdds(0.85)),
                    Some(_) => None,
                }
            };
            let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, state);
            let is_unknown = |&voxel: &usize| snapshot.occupancy()[voxel] == Occupancy::Unknown;
            let value = |voxel: usize| if is_unknown(&voxel) { 1.0 / (voxel + 1) as f64 } else { 0.0 };
            let value: Vec<f64> = (0..block.n_voxels()).map(value).collect();
            let depths = DepthRange { min: near, max: 2.0 };
            let caster = || {
                let caster = RayCaster::new(&snapshot, &cameras()[camera], spacing, FreeSpace::Clear).unwrap();
                caster.within(depths)
            };
            check(caster, &snapshot, &value, &look_at(DVec3::from_array(position), DVec3::splat(0.02)).unwrap())?;
        }
    }

    fn snapshot(states: &[Option<f32>]) -> Snapshot {
        let block = VoxelBlock::new(IVec3::new(-5, -4, -6), UVec3::new(11, 9, 10)).unwrap();
        let state = |key| states[block.index(key).unwrap()].map(LogOdds);
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, state)
    }

    /// Compares with the crossings of single rays, in order, whatever the instructions of the CPU.
    fn check<'a>(
        caster: impl Fn() -> RayCaster<'a>,
        snapshot: &Snapshot,
        value: &[f64],
        pose: &Pose,
    ) -> Result<(), TestCaseError> {
        let item_of = |voxel: usize| {
            (value[voxel] > 0.0).then(|| value[..voxel].iter().filter(|value| **value > 0.0).count())
        };
        for arch in archs() {
            let mut caster = caster();
            caster.arch = arch;
            let mut expected = Vec::new();
            caster.cast(pose, |ray| {
                expected.extend(ray.crossings.iter().filter_map(|crossing| {
                    let quality = value[crossing.voxel as usize] * crossing.visibility as f64;
                    item_of(crossing.voxel as usize).map(|item| (item, quality))
                }))
            });
            let caster = ValueCaster::new(caster, snapshot, value);
            let mut found = Vec::new();
            let sum = caster.cast(pose, &mut caster.paths(), |item, quality| found.push((item, quality)));
            prop_assert_eq!(&found, &expected);
            prop_assert_eq!(sum, expected.iter().fold(0.0, |sum, (_, quality)| sum + quality));
        }
        Ok(())
    }
}
