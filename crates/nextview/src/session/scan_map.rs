use crate::geometry::{Lattice, VoxelBlock};
use crate::map::{Background, Integration, LogOdds, MapUpdate, OccupancyMap, RayRule, SensorModel, Snapshot};
use crate::object::{KnownTable, Place};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// The settings for mapping frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapRules {
    /// Finest voxel size, metres.
    pub voxel_size: f64,
    pub sensor_model: SensorModel,
    pub rays: RayRule,
    pub background: Background,
}

/// The map of a scan in the finest voxels and, while planning uses coarser ones, also in those.
///
/// Both depend only on the frames, the place and the voxel size: when the box grows or the voxels are halved,
/// maps are rebuilt from all frames, so no measurement is lost or invented.
#[derive(Clone, Debug)]
pub(super) struct ScanMap {
    rules: MapRules,
    place: Place,
    finest: BoxMap,
    /// Number of halvings left, and the map in the current voxels; `None` in the finest.
    coarse: Option<(u32, BoxMap)>,
}

/// A map of a box in voxels of one size.
#[derive(Clone, Debug)]
struct BoxMap {
    map: OccupancyMap,
    /// `None` if the box is unknown or holds no voxel.
    block: Option<VoxelBlock>,
    integration: Integration,
    table: Option<KnownTable>,
}

impl ScanMap {
    /// Returns a map without frames.
    pub fn new(rules: MapRules, place: Place) -> Self {
        Self { finest: BoxMap::new(&rules, 0, place), coarse: None, place, rules }
    }

    /// Returns a map without frames and without a place.
    pub fn nowhere(&self) -> Self {
        Self::new(self.rules, Place::default())
    }

    /// Returns a map of the same place in the finest voxels, without frames.
    pub fn without_frames(&self) -> Self {
        Self::new(self.rules, self.place)
    }

    pub fn place(&self) -> Place {
        self.place
    }

    /// Returns the map in the finest voxels.
    pub fn finest(&self) -> &OccupancyMap {
        &self.finest.map
    }

    /// Returns the known state of the box in the finest voxels; `None` before there is a box.
    pub fn finest_snapshot(&self, cancel: &Cancel) -> Result<Option<Snapshot>, Cancelled> {
        self.finest.snapshot(cancel)
    }

    /// Returns the known state of the box in the planning voxels; `None` before there is a box.
    pub fn planning_snapshot(&self, cancel: &Cancel) -> Result<Option<Snapshot>, Cancelled> {
        self.planning().snapshot(cancel)
    }

    /// Returns the edge of the planning voxels, metres.
    pub fn planning_voxel_size(&self) -> f64 {
        self.planning().map.lattice().voxel_size()
    }

    /// Whether planning uses the finest voxels.
    pub fn is_finest(&self) -> bool {
        self.coarse.is_none()
    }

    /// Adds a frame to all maps and returns its changes to the finest one. After cancellation, the maps are
    /// unusable.
    pub fn integrate(&mut self, frame: &Frame, cancel: &Cancel) -> Result<MapUpdate, Cancelled> {
        if let Some((_, coarse)) = &mut self.coarse {
            coarse.integrate(frame, cancel)?;
        }
        self.finest.integrate(frame, cancel)
    }

    /// Rebuilds the maps for another place from all frames. After cancellation, they are unusable.
    pub fn move_to(&mut self, place: Place, frames: &[Frame], cancel: &Cancel) -> Result<(), Cancelled> {
        self.place = place;
        self.finest = BoxMap::of(&self.rules, 0, place, frames, cancel)?;
        self.plan_in(self.coarse.as_ref().map_or(0, |(n_halvings, _)| *n_halvings), frames, cancel)
    }

    /// Switches planning to voxels with this many halvings left, or to finer ones if the box holds none of
    /// those.
    pub fn plan_in(&mut self, n_halvings: u32, frames: &[Frame], cancel: &Cancel) -> Result<(), Cancelled> {
        self.coarse = self.coarse_map(n_halvings, frames, cancel)?;
        Ok(())
    }

    fn coarse_map(
        &self,
        n_halvings: u32,
        frames: &[Frame],
        cancel: &Cancel,
    ) -> Result<Option<(u32, BoxMap)>, Cancelled> {
        let has_voxels = |n: &u32| BoxMap::new(&self.rules, *n, self.place).block.is_some();
        let n = (1..=n_halvings).rev().find(|n| self.place.bounds.is_none() || has_voxels(n));
        n.map(|n| Ok((n, BoxMap::of(&self.rules, n, self.place, frames, cancel)?))).transpose()
    }

    /// Halves the planning voxels, which must not be the finest. If cancelled, they stay unchanged.
    pub fn refine(&mut self, frames: &[Frame], cancel: &Cancel) -> Result<(), Cancelled> {
        let n_halvings = self.coarse.as_ref().map_or(0, |(n_halvings, _)| n_halvings - 1);
        self.coarse = self.coarse_map(n_halvings, frames, cancel)?;
        Ok(())
    }

    fn planning(&self) -> &BoxMap {
        self.coarse.as_ref().map_or(&self.finest, |(_, coarse)| coarse)
    }
}

impl BoxMap {
    fn new(rules: &MapRules, n_halvings: u32, place: Place) -> Self {
        let voxel_size = rules.voxel_size * 2_f64.powi(n_halvings as i32);
        let lattice = Lattice::new(voxel_size).expect("the session checked the voxel size");
        let map =
            OccupancyMap::new(lattice, rules.sensor_model).expect("the session checked the sensor model");
        let block = place.bounds.and_then(|bounds| lattice.block_inside(&bounds));
        let ground = place.table.map(|table| table.top);
        let integration =
            Integration { rays: rules.rays, background: rules.background, region: block, ground };
        Self { map, block, integration, table: place.table }
    }

    fn of(
        rules: &MapRules,
        n_halvings: u32,
        place: Place,
        frames: &[Frame],
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let mut map = Self::new(rules, n_halvings, place);
        for frame in frames {
            map.integrate(frame, cancel)?;
        }
        Ok(map)
    }

    fn integrate(&mut self, frame: &Frame, cancel: &Cancel) -> Result<MapUpdate, Cancelled> {
        cancel.check()?;
        match self.block {
            Some(_) => self.map.integrate_unless(frame, &self.integration, cancel),
            None => Ok(MapUpdate::default()),
        }
    }

    /// Returns the known state of the box. Voxels inside the table, which no frame can show, count as free:
    /// there is nothing to find.
    fn snapshot(&self, cancel: &Cancel) -> Result<Option<Snapshot>, Cancelled> {
        let Some(block) = self.block else { return Ok(None) };
        let snapshot = self.map.snapshot_unless(block, cancel)?;
        let Some(table) = self.table else { return Ok(Some(snapshot)) };
        let lattice = self.map.lattice();
        let reach = 0.5 * lattice.voxel_size() * table.top.normal().abs().element_sum();
        let free = LogOdds::from_probability(self.map.model().clamp_min);
        let is_inside = |key| table.top.height(lattice.center(key)) + reach <= 0.0;
        snapshot.with_value(free, is_inside, cancel).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use crate::geometry::random::Random;
    use crate::map::Occupancy;
    use crate::object::Table;
    use crate::sensor::{DepthImage, Intrinsics};
    use crate::view::look_at;
    use glam::{DVec2, DVec3};

    fn frames(n: usize) -> Vec<Frame> {
        let optics = Intrinsics::pinhole(40, 30, DVec2::splat(40.0), DVec2::new(19.5, 14.5)).unwrap();
        let mut random = Random::new(7, 0);
        let mut frame = || {
            let depth = (0..1200).map(|_| random.range(0.25, 0.75) as f32).collect();
            let image = DepthImage::from_metres(40, 30, depth).unwrap();
            let pose = look_at(random.in_cube().normalize() * 0.5, DVec3::ZERO).unwrap();
            Frame::new(image, optics, pose, 1.0).unwrap()
        };
        (0..n).map(|_| frame()).collect()
    }

    fn rules() -> MapRules {
        MapRules {
            voxel_size: 0.01,
            sensor_model: SensorModel::default(),
            rays: RayRule::default(),
            background: Background::default(),
        }
    }

    fn place(half: f64, table: Table) -> Place {
        Place {
            bounds: Some(Aabb::cube(DVec3::splat(0.013), half)),
            table: table.find(&[], &Cancel::default()).unwrap(),
        }
    }

    /// The maps always equal those built from scratch from the frames, the place and the voxel size.
    fn check_is_from_scratch(map: &ScanMap, frames: &[Frame]) {
        let mut known = Place { ..map.place() };
        let n_halvings = (map.planning_voxel_size() / 0.01).log2().round() as u32;
        for (n, found) in [(0, &map.finest), (n_halvings, map.planning())] {
            let scratch = BoxMap::of(&rules(), n, known, frames, &Cancel::default()).unwrap();
            assert_eq!(found.block, scratch.block);
            assert_eq!(found.map.lattice(), scratch.map.lattice());
            assert_eq!(found.map.voxels(), scratch.map.voxels());
        }
        known.bounds = None;
        let nowhere = BoxMap::of(&rules(), 0, known, frames, &Cancel::default()).unwrap();
        assert!(nowhere.map.voxels().is_empty());
    }

    #[test]
    fn growth_refinement_and_frames_in_any_order_give_the_map_from_scratch() {
        let frames = frames(6);
        let (mut random, never) = (Random::new(3, 0), &Cancel::default());
        for _ in 0..10 {
            let mut map = ScanMap::new(rules(), Place::default());
            map.plan_in(3, &[], never).unwrap();
            let (mut seen, mut half) = (0, 0.08);
            while seen < frames.len() {
                match random.index(4) {
                    0 => {
                        half += 0.02;
                        map.move_to(place(half, Table::AtHeight(-0.05)), &frames[..seen], never).unwrap();
                    }
                    1 if !map.is_finest() => map.refine(&frames[..seen], never).unwrap(),
                    _ => {
                        map.integrate(&frames[seen], never).unwrap();
                        seen += 1;
                    }
                }
                check_is_from_scratch(&map, &frames[..seen]);
            }
        }
    }

    #[test]
    fn voxel_sizes_that_the_box_holds_none_of_are_passed_over() {
        let mut map = ScanMap::new(rules(), place(0.02, Table::None));
        map.plan_in(10, &[], &Cancel::default()).unwrap();
        assert!(
            map.planning_snapshot(&Cancel::default()).unwrap().is_some() && map.planning_voxel_size() < 0.1
        );
    }

    #[test]
    fn nothing_is_to_be_found_inside_the_table() {
        let mut map = ScanMap::new(rules(), place(0.05, Table::AtHeight(-0.011)));
        let never = &Cancel::default();
        frames(2).iter().for_each(|frame| _ = map.integrate(frame, never).unwrap());
        let below = |key: glam::IVec3| (key.z + 1) as f64 * 0.01 <= -0.009;
        // Voxels that a tilted table would leave in the box.
        map.finest.block = Lattice::new(0.01).unwrap().block_inside(&Aabb::cube(DVec3::ZERO, 0.05));
        let snapshot = map.finest_snapshot(never).unwrap().unwrap();
        let block = snapshot.block();
        assert!((0..block.n_voxels()).any(|i| below(block.key(i))));
        for i in (0..block.n_voxels()).filter(|&i| below(block.key(i))) {
            assert_eq!(snapshot.occupancy()[i], Occupancy::Free);
        }
        assert!(snapshot.count(Occupancy::Unknown) > 0);
    }
}
