//! Scan integration, the only writer of a map. A scan updates each voxel once, and a hit overrides a miss.

use super::brick::CELLS;
use super::integration::{Integration, MapUpdate};
use super::key_box::KeyBox;
use super::marks::{HIT, MISS, Marks};
use super::scan::{ScanRules, VoxelScan};
use super::{LogOdds, OccupancyMap, SensorModel};
use crate::geometry::check_position;
use crate::instructions::instructions;
use crate::sensor::Frame;
use crate::{Cancel, Cancelled, Error};
use glam::DVec3;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

impl OccupancyMap {
    /// Integrates a depth frame into the map.
    ///
    /// Without a [region](Integration::region), it fails and changes nothing if a ray ends beyond
    /// [`Lattice::REACH`](crate::geometry::Lattice::REACH), if the rays cross more than 2^33 voxels in total
    /// (some ten seconds), or if they touch more than 2^21 bricks of 8 x 8 x 8 voxels (4.3 GB).
    pub fn integrate(&mut self, frame: &Frame, integration: &Integration) -> Result<MapUpdate, Error> {
        let rules = ScanRules::new(self.lattice(), frame.world_from_camera().translation(), integration);
        self.check_and_write(rules.scan_of_frame(frame), &rules)
    }

    /// As [`integrate`](Self::integrate) in a region, unless cancelled; after cancellation, the map is
    /// unusable.
    pub(crate) fn integrate_unless(
        &mut self,
        frame: &Frame,
        integration: &Integration,
        cancel: &Cancel,
    ) -> Result<MapUpdate, Cancelled> {
        debug_assert!(integration.region.is_some(), "a region bounds the scan");
        let rules = ScanRules::new(self.lattice(), frame.world_from_camera().translation(), integration);
        self.write(rules.scan_of_frame(frame), &rules, cancel)
    }

    /// Integrates a cloud of surface points, seen from `origin`, into the map (world coordinates, metres).
    /// Points that are not finite are skipped.
    ///
    /// Fails and changes nothing if the origin is not within [`Pose::REACH`](crate::geometry::Pose::REACH),
    /// or as [`integrate`](Self::integrate) does.
    pub fn integrate_points(
        &mut self,
        points: &[DVec3],
        origin: DVec3,
        integration: &Integration,
    ) -> Result<MapUpdate, Error> {
        check_position("origin", origin)?;
        let rules = ScanRules::new(self.lattice(), origin, integration);
        let parts = points.par_chunks(1 << 14).map(|points| {
            let finite = points.iter().filter(|point| point.is_finite());
            rules.scan(finite.map(|&point| (point, true)))
        });
        self.check_and_write(VoxelScan::union(parts.collect(), &rules), &rules)
    }

    fn check_and_write(&mut self, scan: VoxelScan, rules: &ScanRules) -> Result<MapUpdate, Error> {
        if rules.region.is_none() {
            scan.check_size(rules.origin)?;
        }
        Ok(self.write(scan, rules, &Cancel::default())?)
    }

    fn write(&mut self, scan: VoxelScan, rules: &ScanRules, cancel: &Cancel) -> Result<MapUpdate, Cancelled> {
        cancel.check()?;
        let keys = rules.region.or_else(|| scan.reach(rules.origin));
        let mut writer = Writer {
            origin: rules.origin,
            steps: Steps::new(self.model()),
            map: self,
            marks: Marks::default(),
            update: MapUpdate::default(),
            cancel,
        };
        keys.map_or(Ok(()), |keys| writer.write(scan, keys))?;
        Ok(writer.update)
    }
}

/// Bricks along the edge of a tile. The marks of a tile, 2 MB, stay in the cache while rays are traced
/// through it.
const TILE_EDGE: i32 = 16;

/// Writes a scan tile by tile.
struct Writer<'a> {
    origin: DVec3,
    steps: Steps,
    map: &'a mut OccupancyMap,
    marks: Marks,
    update: MapUpdate,
    cancel: &'a Cancel,
}

impl Writer<'_> {
    fn write(&mut self, scan: VoxelScan, keys: KeyBox) -> Result<(), Cancelled> {
        if scan.ends.is_empty() {
            return Ok(());
        }
        self.cancel.check()?;
        match keys.halves(TILE_EDGE) {
            Some(halves) => {
                halves.into_iter().try_for_each(|half| self.write(scan.within(self.origin, &half), half))
            }
            None => {
                self.write_tile(&scan, keys);
                Ok(())
            }
        }
    }

    fn write_tile(&mut self, scan: &VoxelScan, keys: KeyBox) {
        instructions().dispatch(WriteTile { writer: self, scan, keys });
    }
}

struct WriteTile<'a, 'b> {
    writer: &'a mut Writer<'b>,
    scan: &'a VoxelScan,
    keys: KeyBox,
}

impl WithSimd for WriteTile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Writer { origin, steps, map, marks, update, .. } = self.writer;
        marks.visit(
            *origin,
            self.scan,
            self.keys,
            #[inline(always)]
            |brick, marks| {
                let slot = map.bricks.slot(brick);
                steps.apply(&mut map.bricks.at_mut(slot).0, marks, update);
            },
        );
    }
}

/// The changes of log-odds.
struct Steps {
    hit: f32,
    miss: f32,
    low: f32,
    high: f32,
}

impl Steps {
    fn new(model: &SensorModel) -> Self {
        let [hit, miss, low, high] =
            [model.hit, model.miss, model.clamp_min, model.clamp_max].map(|p| LogOdds::from_probability(p).0);
        Self { hit, miss, low, high }
    }

    /// Updates the marked voxels of a brick, without branches, for vector instructions.
    #[inline(always)]
    fn apply(&self, values: &mut [f32; CELLS], marks: &[u8; CELLS], update: &mut MapUpdate) {
        let [mut n_hits, mut n_misses, mut n_first_measured, mut n_newly_occupied] = [0_u32; 4];
        for (value, &mark) in values.iter_mut().zip(marks) {
            let before = *value;
            let (is_hit, is_marked) = (mark == HIT, mark != 0);
            let start = if before.is_nan() { 0.0 } else { before };
            let sum = start + if is_hit { self.hit } else { self.miss };
            let after = if sum < self.low { self.low } else { sum };
            let after = if after > self.high { self.high } else { after };
            *value = if is_marked { after } else { before };
            n_hits += is_hit as u32;
            n_misses += (mark == MISS) as u32;
            n_first_measured += (is_marked & before.is_nan()) as u32;
            n_newly_occupied += (is_marked & (start <= 0.0) & (after > 0.0)) as u32;
        }
        update.n_hits += n_hits as usize;
        update.n_misses += n_misses as usize;
        update.n_first_measured += n_first_measured as usize;
        update.n_newly_occupied += n_newly_occupied as usize;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VoxelBlock;
    use crate::geometry::{Lattice, Pose, SegmentWalk, sphere};
    use crate::map::{Background, RayRule};
    use crate::sensor::{DepthImage, Intrinsics};
    use glam::{DVec2, IVec3, UVec3};
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn empty_map() -> OccupancyMap {
        OccupancyMap::new(Lattice::new(0.1).unwrap(), SensorModel::default()).unwrap()
    }

    fn points(n: usize) -> impl Strategy<Value = Vec<DVec3>> {
        let coordinate = || -1.5..1.5;
        let point = (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| DVec3::new(x, y, z));
        prop::collection::vec(point, 1..n)
    }

    /// The slow twin: sets of keys from complete walks, then one update a voxel.
    fn by_definition(points: &[DVec3], origin: DVec3, rule: RayRule) -> BTreeMap<[i32; 3], f32> {
        let lattice = Lattice::new(0.1).unwrap();
        let mut cells = BTreeMap::new();
        for &point in points {
            let target = match rule {
                RayRule::EveryPoint => lattice.to_voxels(point),
                RayRule::OnePerEndVoxel => lattice.key(point).as_dvec3() + 0.5,
            };
            let mut walk = SegmentWalk::new(lattice.to_voxels(origin), target);
            while walk.key() != lattice.key(point) {
                cells.entry(walk.key().to_array()).or_insert(LogOdds::from_probability(0.4).0);
                walk.advance();
            }
        }
        for &point in points {
            cells.insert(lattice.key(point).to_array(), LogOdds::from_probability(0.7).0);
        }
        cells
    }

    fn cells(map: &OccupancyMap) -> BTreeMap<[i32; 3], f32> {
        map.voxels().into_iter().map(|(key, value)| (key.to_array(), value.0)).collect()
    }

    proptest! {
        #[test]
        fn updates_each_voxel_once_and_hits_win(points in points(40), per_end in any::<bool>()) {
            let rays = if per_end { RayRule::OnePerEndVoxel } else { RayRule::EveryPoint };
            let origin = DVec3::new(0.03, -2.0, 0.4);
            let mut map = empty_map();
            let update = map.integrate_points(&points, origin, &Integration { rays, ..Default::default() }).unwrap();
            let expected = by_definition(&points, origin, rays);
            prop_assert_eq!(update.n_hits + update.n_misses, expected.len());
            prop_assert_eq!(update.n_first_measured, expected.len());
            prop_assert_eq!(update.n_newly_occupied, update.n_hits);
            prop_assert_eq!(cells(&map), expected);
        }

        /// A region limits the updates, not the measurements.
        #[test]
        fn a_region_cuts_nothing_but_what_lies_outside(points in points(40), per_end in any::<bool>()) {
            let rays = if per_end { RayRule::OnePerEndVoxel } else { RayRule::EveryPoint };
            let region = VoxelBlock::new(IVec3::new(-6, -5, -4), UVec3::new(9, 12, 7));
            let origin = DVec3::new(0.03, -2.0, 0.4);
            let (mut whole, mut clipped) = (empty_map(), empty_map());
            whole.integrate_points(&points, origin, &Integration { rays, ..Default::default() }).unwrap();
            clipped.integrate_points(&points, origin, &Integration { rays, region, ..Default::default() }).unwrap();
            let mut expected = cells(&whole);
            expected.retain(|&key, _| region.unwrap().index(key.into()).is_some());
            prop_assert_eq!(cells(&clipped), expected);
        }

        #[test]
        fn ignoring_the_background_leaves_out_rays_that_end_outside(points in points(40)) {
            let region = VoxelBlock::new(IVec3::new(-6, -5, -4), UVec3::new(9, 12, 7));
            let origin = DVec3::new(0.03, -2.0, 0.4);
            let inside = |p: &&DVec3| region.unwrap().index(Lattice::new(0.1).unwrap().key(**p)).is_some();
            let on_object: Vec<DVec3> = points.iter().filter(inside).copied().collect();
            let (mut ignoring, mut object_only) = (empty_map(), empty_map());
            let background = Background::Ignore;
            ignoring.integrate_points(&points, origin, &Integration { background, region, ..Default::default() }).unwrap();
            object_only.integrate_points(&on_object, origin, &Integration { region, ..Default::default() }).unwrap();
            prop_assert_eq!(cells(&ignoring), cells(&object_only));
        }
    }

    #[test]
    fn repeated_scans_clamp() {
        let mut map = empty_map();
        for _ in 0..20 {
            map.integrate_points(
                &[DVec3::new(0.55, 0.05, 0.05)],
                DVec3::splat(0.05),
                &Integration::default(),
            )
            .unwrap();
        }
        let low = LogOdds::from_probability(0.1192);
        let high = LogOdds::from_probability(0.971);
        assert_eq!((map.log_odds(IVec3::ZERO), map.log_odds(IVec3::new(5, 0, 0))), (Some(low), Some(high)));
    }

    #[test]
    fn a_frame_carves_where_nothing_came_back_and_nothing_where_nothing_is_known() {
        let camera = Intrinsics::pinhole(3, 1, DVec2::ONE, DVec2::new(1.0, 0.0)).unwrap();
        // Left: a surface at 0.55 m; middle: nothing came back up to 1 m; right: no measurement.
        let image = DepthImage::from_metres(3, 1, vec![0.55, f32::INFINITY, f32::NAN]).unwrap();
        let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
        let mut map = empty_map();
        let update = map.integrate(&frame, &Integration::default()).unwrap();
        assert_eq!(update.n_hits, 1);
        assert_eq!(map.log_odds(IVec3::new(-6, 0, 5)).map(|v| v.0 > 0.0), Some(true), "the surface");
        assert_eq!(map.log_odds(IVec3::new(0, 0, 9)).map(|v| v.0 < 0.0), Some(true), "free up to the range");
        assert_eq!(map.log_odds(IVec3::new(2, 0, 3)), None, "unknown to the right");
    }

    #[test]
    fn threads_do_not_show() {
        let camera = Intrinsics::pinhole(64, 48, DVec2::splat(40.0), DVec2::new(32.0, 24.0)).unwrap();
        let depth = (0..64 * 48).map(|i| 0.5 + (i % 7) as f32 * 0.1).collect();
        let image = DepthImage::from_metres(64, 48, depth).unwrap();
        let frame = Frame::new(image, camera, Pose::IDENTITY, 2.0).unwrap();
        for rays in [RayRule::EveryPoint, RayRule::OnePerEndVoxel] {
            let run = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut map = empty_map();
                let update = pool
                    .install(|| map.integrate(&frame, &Integration { rays, ..Default::default() }).unwrap());
                (update, cells(&map))
            };
            assert_eq!(run(1), run(4));
        }
    }

    /// Time and memory are bounded, and the map is unchanged.
    #[test]
    fn refuses_scans_without_bounds() {
        let check = |points: &[DVec3], origin: DVec3, expected: &str| {
            let mut map = empty_map();
            let error =
                map.integrate_points(points, origin, &Integration::default()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
            assert!(map.voxels().is_empty());
        };
        check(&[DVec3::X * 1e300], DVec3::ZERO, "distance of a point from the origin");
        check(&[DVec3::X], DVec3::X * f64::NAN, "origin is");
        check(&[DVec3::X], DVec3::X * 1e300, "origin is");
        let far: Vec<DVec3> = (0..3000).map(|i| DVec3::new(1e6, i as f64, 0.0)).collect();
        check(&far, DVec3::ZERO, "voxels crossed");
        let spread: Vec<DVec3> = (0..3000).map(|i| sphere::fibonacci(i, 3000) * 1000.0).collect();
        check(&spread, DVec3::ZERO, "more than the limit of 4294 MB");
    }

    #[test]
    fn a_region_bounds_any_scan() {
        let region = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(9));
        let integration = Integration { region, ..Default::default() };
        let mut map = empty_map();
        let ends =
            [1e4, 1e30, 1e300, f64::MAX, f64::INFINITY, f64::NAN].map(|x| DVec3::new(x, 1e-3 * x, 0.0));
        let update = map.integrate_points(&ends, DVec3::new(-1.0, 0.05, 0.05), &integration).unwrap();
        assert_eq!((update.n_hits, update.n_misses), (0, 9), "one line through the region");
        let far = DVec3::new(-1e8, 0.05, 0.05);
        assert_eq!(map.integrate_points(&ends[..1], far, &integration).unwrap().n_hits, 0);
    }

    #[test]
    fn a_frame_of_a_far_wall_ends() {
        let camera = Intrinsics::pinhole(64, 48, DVec2::splat(40.0), DVec2::new(32.0, 24.0)).unwrap();
        for depth in [1e4, 1e6, f32::MAX] {
            let image = DepthImage::from_metres(64, 48, vec![depth; 64 * 48]).unwrap();
            let frame = Frame::new(image, camera, Pose::IDENTITY, 2.0).unwrap();
            assert!(empty_map().integrate(&frame, &Integration::default()).is_err());
        }
    }
}
