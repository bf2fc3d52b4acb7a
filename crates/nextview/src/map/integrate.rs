//! Scan integration: the only writer of a map. A scan updates each voxel once, and a hit wins over a miss.

use super::brick::{BrickGrid, CELLS, brick_key, cell};
use super::{LogOdds, OccupancyMap};
use crate::geometry::{Plane, SegmentWalk, VoxelBlock, VoxelKey};
use crate::sensor::Frame;
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};

/// Which rays of a scan are traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayRule {
    /// A ray to every measured point. The default.
    #[default]
    EveryPoint,
    /// One ray to the centre of every voxel that holds a measured point (OctoMap's `discretize`).
    OnePerEndVoxel,
}

/// What rays that end outside the region of interest, behind or beside the object, may do to the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Background {
    /// They carve free space on their way through the region. The default.
    #[default]
    Carve,
    /// They are left out, as in the paper's simulation, where only points on the object exist.
    Ignore,
}

/// How a scan is written into a map.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integration {
    /// Which rays are traced.
    pub rays: RayRule,
    /// What rays that end outside the region do.
    pub background: Background,
    /// The voxels that may change; all of space by default.
    pub region: Option<VoxelBlock>,
    /// A surface that is not to be mapped, such as a table, with the tolerance added: points that are not above it end
    /// a free ray and do not hit. None by default.
    pub ground: Option<Plane>,
}

/// What a scan changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapUpdate {
    /// Voxels that were updated as hit.
    pub n_hits: usize,
    /// Voxels that were updated as crossed.
    pub n_misses: usize,
    /// Voxels measured for the first time.
    pub n_first_measured: usize,
    /// Voxels that became occupied.
    pub n_newly_occupied: usize,
}

impl OccupancyMap {
    /// Writes a depth frame into the map.
    pub fn integrate(&mut self, frame: &Frame, integration: &Integration) -> MapUpdate {
        let origin = frame.world_from_camera().translation();
        // Rows in parallel: marks are unions of bits, so that the order of the rows cannot show.
        let rows: Vec<u32> = (0..frame.image().height()).collect();
        let marks = rows
            .par_chunks(16)
            .map(|rows| {
                let mut marks = ScanMarks::new(self, origin, integration);
                rows.iter().for_each(|&v| frame.row_ray_ends(v).for_each(|(end, hit)| marks.add(end, hit)));
                marks
            })
            .reduce_with(ScanMarks::union);
        marks.map(ScanMarks::finish).map_or_else(MapUpdate::default, |marks| self.apply(&marks))
    }

    /// Writes a cloud of surface points, seen from `origin`, into the map (world coordinates, metres).
    pub fn integrate_points(
        &mut self,
        points: &[DVec3],
        origin: DVec3,
        integration: &Integration,
    ) -> MapUpdate {
        let mut marks = ScanMarks::new(self, origin, integration);
        points.iter().filter(|point| point.is_finite()).for_each(|&point| marks.add(point, true));
        self.apply(&marks.finish())
    }

    fn apply(&mut self, marks: &BrickGrid<Marks>) -> MapUpdate {
        let model = *self.model();
        let [hit, miss, low, high] =
            [model.hit, model.miss, model.clamp_min, model.clamp_max].map(|p| LogOdds::from_probability(p).0);
        let mut update = MapUpdate::default();
        for (key, marks) in marks.iter() {
            let slot = self.bricks.slot(key);
            let values = &mut self.bricks.at_mut(slot).0;
            for (cell, value) in values.iter_mut().enumerate() {
                let (is_hit, is_miss) = (marks.hit.contains(cell), marks.miss.contains(cell));
                if !is_hit && !is_miss {
                    continue;
                }
                let before = *value;
                let start = if before.is_nan() { 0.0 } else { before };
                let after = (start + if is_hit { hit } else { miss }).clamp(low, high);
                *value = after;
                update.n_hits += is_hit as usize;
                update.n_misses += !is_hit as usize;
                update.n_first_measured += before.is_nan() as usize;
                update.n_newly_occupied += (start <= 0.0 && after > 0.0) as usize;
            }
        }
        update
    }
}

/// The voxels that a scan hit and crossed.
struct ScanMarks {
    bricks: BrickGrid<Marks>,
    /// Voxels that were already the end of a ray, where one ray per end voxel is asked for.
    ends: Option<FxHashSet<VoxelKey>>,
    /// The origin in units of voxels.
    origin: DVec3,
    lattice: crate::geometry::Lattice,
    background: Background,
    region: Option<Region>,
    ground: Option<Plane>,
}

#[derive(Clone, Copy)]
struct Region {
    min: IVec3,
    max: IVec3,
}

#[derive(Clone, Default)]
struct Marks {
    hit: CellSet,
    miss: CellSet,
}

#[derive(Clone, Copy, Default)]
struct CellSet([u64; CELLS / 64]);

impl CellSet {
    fn insert(&mut self, cell: usize) {
        self.0[cell / 64] |= 1 << (cell % 64);
    }

    fn contains(&self, cell: usize) -> bool {
        self.0[cell / 64] >> (cell % 64) & 1 == 1
    }

    fn extend(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a |= b);
    }
}

impl Region {
    fn new(block: VoxelBlock) -> Self {
        Self { min: block.min(), max: block.max() }
    }

    fn contains(&self, key: VoxelKey) -> bool {
        key.cmpge(self.min).all() && key.cmple(self.max).all()
    }
}

impl ScanMarks {
    fn new(map: &OccupancyMap, origin: DVec3, integration: &Integration) -> Self {
        Self {
            bricks: BrickGrid::default(),
            ends: (integration.rays == RayRule::OnePerEndVoxel).then(FxHashSet::default),
            origin: map.lattice().to_voxels(origin),
            lattice: map.lattice(),
            background: integration.background,
            region: integration.region.map(Region::new),
            ground: integration.ground,
        }
    }

    /// Adds the ray to `end` (world coordinates), which is a surface if `hit`.
    ///
    /// Where one ray per end voxel is asked for, only the end is noted here and traced by
    /// [`finish`](Self::finish), so that each is traced once even if several image rows end in it.
    fn add(&mut self, end: DVec3, hit: bool) {
        let hit = hit && self.ground.is_none_or(|ground| ground.height(end) > 0.0);
        let end = self.lattice.to_voxels(end);
        let end_key = end.floor().as_ivec3();
        let inside = self.region.is_none_or(|region| region.contains(end_key));
        if !inside && self.background == Background::Ignore {
            return;
        }
        if inside && hit {
            let slot = self.bricks.slot(brick_key(end_key));
            self.bricks.at_mut(slot).hit.insert(cell(end_key));
        }
        match &mut self.ends {
            Some(ends) => _ = ends.insert(end_key),
            None => self.cross(end),
        }
    }

    fn union(mut self, other: Self) -> Self {
        for (key, marks) in other.bricks.iter() {
            let slot = self.bricks.slot(key);
            let mine = self.bricks.at_mut(slot);
            mine.hit.extend(&marks.hit);
            mine.miss.extend(&marks.miss);
        }
        if let (Some(ends), Some(others)) = (&mut self.ends, other.ends) {
            ends.extend(others);
        }
        self
    }

    fn finish(mut self) -> BrickGrid<Marks> {
        // The order of the set does not show: marks are unions.
        for end in self.ends.take().into_iter().flatten() {
            self.cross(end.as_dvec3() + 0.5);
        }
        self.bricks
    }

    /// Marks the voxels before the end (in units of voxels) as crossed, within the region.
    fn cross(&mut self, end: DVec3) {
        let Some(mut walk) = self.walk_to(end) else { return };
        let end_key = end.floor().as_ivec3();
        let mut brick = brick_key(walk.key());
        let mut slot = self.bricks.slot(brick);
        loop {
            let key = walk.key();
            if key == end_key {
                return;
            }
            if brick_key(key) != brick {
                brick = brick_key(key);
                slot = self.bricks.slot(brick);
            }
            self.bricks.at_mut(slot).miss.insert(cell(key));
            if walk.advance().is_none() {
                return;
            }
        }
    }

    fn walk_to(&self, end: DVec3) -> Option<SegmentWalk> {
        match self.region {
            Some(region) => SegmentWalk::within(self.origin, end, region.min, region.max),
            None => Some(SegmentWalk::new(self.origin, end)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, Pose};
    use crate::map::SensorModel;
    use crate::sensor::{DepthImage, Intrinsics};
    use glam::{DVec2, UVec3};
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
            let update = map.integrate_points(&points, origin, &Integration { rays, ..Default::default() });
            let expected = by_definition(&points, origin, rays);
            prop_assert_eq!(update.n_hits + update.n_misses, expected.len());
            prop_assert_eq!(update.n_first_measured, expected.len());
            prop_assert_eq!(update.n_newly_occupied, update.n_hits);
            prop_assert_eq!(cells(&map), expected);
        }

        /// A region changes what is written, not what is measured.
        #[test]
        fn a_region_cuts_nothing_but_what_lies_outside(points in points(40), per_end in any::<bool>()) {
            let rays = if per_end { RayRule::OnePerEndVoxel } else { RayRule::EveryPoint };
            let region = VoxelBlock::new(IVec3::new(-6, -5, -4), UVec3::new(9, 12, 7));
            let origin = DVec3::new(0.03, -2.0, 0.4);
            let (mut whole, mut clipped) = (empty_map(), empty_map());
            whole.integrate_points(&points, origin, &Integration { rays, ..Default::default() });
            clipped.integrate_points(&points, origin, &Integration { rays, region, ..Default::default() });
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
            ignoring.integrate_points(&points, origin, &Integration { background, region, ..Default::default() });
            object_only.integrate_points(&on_object, origin, &Integration { region, ..Default::default() });
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
            );
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
        let update = map.integrate(&frame, &Integration::default());
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
                let update =
                    pool.install(|| map.integrate(&frame, &Integration { rays, ..Default::default() }));
                (update, cells(&map))
            };
            assert_eq!(run(1), run(4));
        }
    }
}
