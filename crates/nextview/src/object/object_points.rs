//! Finds the measured points of an object of unknown size and place.

use super::connected_cells::{ConnectedCells, gap};
use super::table::ShownTable;
use crate::geometry::{Aabb, Lattice};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use glam::{DVec2, DVec3, IVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// Edge of the cells in which points are pooled, in voxels.
const CELL_IN_VOXELS: f64 = 2.0;

/// Minimum number of points of an object.
pub(super) const LEAST_POINTS: usize = 20;

/// Factor on the distance of things outside the middle of the first image. A wall in the middle is usually
/// more than twice as far as the object next to it, and anything nearer at the image's edge is usually the
/// robot.
const BESIDE_THE_MIDDLE: f64 = 2.0;

/// The points of all frames without the table, pooled in cells, and the object among them: the cells
/// connected by faces, edges or corners, or across gaps, to the object in the first frame that shows one.
///
/// That first object is the nearest thing of at least 20 points; a thing outside the middle half of the image
/// counts as twice as far.
#[derive(Clone, Debug)]
pub(super) struct ObjectPoints {
    lattice: Lattice,
    /// The bounding box of the points in each occupied cell.
    cells: FxHashMap<IVec3, Aabb>,
    object: FxHashSet<IVec3>,
    /// Largest gap between parts of one object, metres; 0 if they must touch.
    max_gap: f64,
}

/// Connected cells, and their position in the first image.
#[derive(Default)]
struct Thing {
    cells: FxHashSet<IVec3>,
    n_points: usize,
    /// Smallest depth, and whether a point is in the middle half of the image.
    nearest: f64,
    is_in_the_middle: bool,
}

impl ObjectPoints {
    /// Returns an empty set for voxels of a valid size and gaps up to this (metres).
    pub fn new(voxel_size: f64, max_gap: f64) -> Self {
        let lattice = Lattice::new(CELL_IN_VOXELS * voxel_size).expect("the session checked the voxel size");
        Self { lattice, cells: FxHashMap::default(), object: FxHashSet::default(), max_gap }
    }

    /// Returns a copy without points.
    pub fn without_points(&self) -> Self {
        Self { cells: FxHashMap::default(), object: FxHashSet::default(), ..*self }
    }

    /// Removes the points of all frames.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.object.clear();
    }

    /// Adds the points of these frames without their tables. After cancellation, the points are unusable.
    pub fn add_all<'a>(
        &mut self,
        frames: impl Iterator<Item = (&'a Frame, Option<ShownTable>)>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        for (frame, table) in frames {
            cancel.check()?;
            self.add(frame, table, cancel)?;
        }
        Ok(())
    }

    /// Adds the points of a frame. After cancellation, the points are unusable.
    pub fn add(
        &mut self,
        frame: &Frame,
        table: Option<ShownTable>,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let points: Vec<DVec3> = surface_points(frame, table).collect();
        cancel.check()?;
        for &point in &points {
            let cell = self.cells.entry(self.lattice.key(point)).or_insert(Aabb { min: point, max: point });
            *cell = Aabb { min: cell.min.min(point), max: cell.max.max(point) };
        }
        cancel.check()?;
        let start = match self.object.is_empty() {
            true => self.first_object(frame, &points, cancel)?,
            false => std::mem::take(&mut self.object),
        };
        cancel.check()?;
        self.object = self.search(cancel).around(start)?;
        Ok(())
    }

    /// Returns the bounding box of the object's points; `None` before there is an object.
    pub fn bounds(&self) -> Option<Aabb> {
        self.bounds_of(&self.object)
    }

    /// Returns the bounding box of the points in these cells; `None` if there are no cells.
    pub fn bounds_of(&self, cells: &FxHashSet<IVec3>) -> Option<Aabb> {
        // The box does not depend on the order of the cells.
        Aabb::around(cells.iter().flat_map(|key| {
            let cell = &self.cells[key];
            [cell.min, cell.max]
        }))
    }

    /// Returns the cells of the object.
    pub fn object(&self) -> &FxHashSet<IVec3> {
        &self.object
    }

    /// Returns the cell of a point.
    pub fn cell(&self, point: DVec3) -> IVec3 {
        self.lattice.key(point)
    }

    /// Returns the smallest distance of these cells from the object, metres; `None` if there is no object.
    pub fn gap_to_object(&self, cells: &FxHashSet<IVec3>) -> Option<f64> {
        let whole = self.bounds()?;
        let nearest = |nearest: f64, cell: &IVec3| {
            let bounds = &self.cells[cell];
            if gap(bounds, &whole) >= nearest {
                return nearest;
            }
            self.object.iter().map(|other| gap(bounds, &self.cells[other])).fold(nearest, f64::min)
        };
        Some(cells.iter().fold(f64::INFINITY, nearest))
    }

    /// Returns a search for connected cells.
    pub fn search<'a>(&'a self, cancel: &'a Cancel) -> ConnectedCells<'a> {
        ConnectedCells::new(&self.cells, self.lattice.voxel_size(), self.max_gap, cancel)
    }

    /// Returns the cells of the object in this frame; empty if no thing is large enough.
    fn first_object(
        &self,
        frame: &Frame,
        points: &[DVec3],
        cancel: &Cancel,
    ) -> Result<FxHashSet<IVec3>, Cancelled> {
        let things = self.things(frame, points, cancel)?;
        let distance =
            |thing: &Thing| thing.nearest * if thing.is_in_the_middle { 1.0 } else { BESIDE_THE_MIDDLE };
        let large = things.into_iter().filter(|thing| thing.n_points >= LEAST_POINTS);
        let object = large.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        Ok(object.map(|thing| thing.cells).unwrap_or_default())
    }

    /// Returns the things formed by the points (of this frame), in the order of their first points.
    fn things(&self, frame: &Frame, points: &[DVec3], cancel: &Cancel) -> Result<Vec<Thing>, Cancelled> {
        let camera_from_world = frame.world_from_camera().inverse();
        let mut search = self.search(cancel);
        let (mut things, mut thing_of): (Vec<Thing>, FxHashMap<IVec3, usize>) = Default::default();
        for &point in points {
            let key = self.lattice.key(point);
            let idx = *thing_of.entry(key).or_insert(things.len());
            if idx == things.len() {
                let cells = search.around(FxHashSet::from_iter([key]))?;
                things.push(Thing { cells, nearest: f64::INFINITY, ..Thing::default() });
                thing_of.extend(things[idx].cells.iter().map(|cell| (*cell, idx)));
            }
            let in_camera = camera_from_world.transform_point(point);
            let thing = &mut things[idx];
            thing.n_points += 1;
            thing.nearest = thing.nearest.min(in_camera.z);
            thing.is_in_the_middle |= is_in_the_middle(frame, in_camera);
        }
        Ok(things)
    }
}

/// Returns the points of a frame without the table.
fn surface_points(frame: &Frame, table: Option<ShownTable>) -> impl Iterator<Item = DVec3> + '_ {
    frame.points().filter(move |point| table.is_none_or(|table| table.is_below(*point)))
}

fn is_in_the_middle(frame: &Frame, point_in_camera: DVec3) -> bool {
    let size = DVec2::new(frame.image().width() as f64, frame.image().height() as f64);
    let middle = 0.5 * (size - 1.0);
    let pixel = frame.intrinsics().project(point_in_camera);
    pixel.is_some_and(|pixel| (pixel - middle).abs().cmple(0.25 * size).all())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::Table;
    use crate::object::other_body::{OtherBody, other_bodies};
    use crate::sensor::{DepthImage, Intrinsics};
    use crate::view::look_at;

    const VOXEL_SIZE: f64 = 0.01;

    /// The frame of a camera 1 m above the origin that looks down on flat things. Their height is given by
    /// column and row of the image, in steps of 1 cm; 0 is the ground.
    fn frame(height: impl Fn(i32, i32) -> f64) -> Frame {
        let optics = Intrinsics::pinhole(200, 200, DVec2::splat(100.0), DVec2::splat(99.5)).unwrap();
        let depth = (0..40_000).map(|i| (1.0 - height(i % 200 - 100, i / 200 - 100)) as f32).collect();
        let image = DepthImage::from_metres(200, 200, depth).unwrap();
        Frame::new(image, optics, look_at(DVec3::Z, DVec3::ZERO).unwrap(), 3.0).unwrap()
    }

    fn square(u: i32, v: i32, at: (i32, i32), half: i32) -> bool {
        (u - at.0).abs() <= half && (v - at.1).abs() <= half
    }

    fn bounds(frames: &[Frame], table: Table) -> Option<Aabb> {
        points(frames, table, 0.0).bounds()
    }

    fn points(frames: &[Frame], table: Table, max_gap: f64) -> ObjectPoints {
        let mut points = ObjectPoints::new(VOXEL_SIZE, max_gap);
        for frame in frames {
            let table =
                table.find(frames, &Cancel::default()).unwrap().map(|table| ShownTable::new(table, frame));
            points.add(frame, table, &Cancel::default()).unwrap();
        }
        points
    }

    /// Two squares, 0.16 m apart; the second is larger and lower.
    fn two() -> Frame {
        frame(|u, v| match () {
            _ if square(u, v, (0, 0), 10) => 0.3,
            _ if square(u, v, (45, 0), 15) => 0.25,
            _ => 0.0,
        })
    }

    #[test]
    fn bodies_are_one_object_across_a_gap() {
        for table in [Table::None, Table::AtHeight(0.0), Table::Fitted] {
            let apart = points(&[two()], table, 0.0).bounds().unwrap();
            assert!(apart.size().x < 0.2, "{apart:?}");
            let near = points(&[two()], table, 0.14).bounds().unwrap();
            assert_eq!(near, apart, "the gap is wider");
            let both = points(&[two()], table, 0.18).bounds().unwrap();
            assert!((both.min.z - 0.25).abs() < 1e-6 && both.size().x > 0.5, "{both:?}");
        }
    }

    #[test]
    fn other_bodies_are_found_and_walls_are_not() {
        let never = &Cancel::default();
        for table in [Table::None, Table::AtHeight(0.0), Table::Fitted] {
            // A wall along one side of the image, and a speck.
            let scene = frame(|u, v| match () {
                _ if square(u, v, (0, 0), 10) => 0.3,
                _ if square(u, v, (45, 0), 15) => 0.25,
                _ if v > 80 => 0.6,
                _ if square(u, v, (-60, -60), 1) => 0.2,
                _ => 0.0,
            });
            let found = points(std::slice::from_ref(&scene), table, 0.0);
            let bodies = other_bodies(&found, &[scene], table.find(&[two()], never).unwrap(), never).unwrap();
            assert_eq!(bodies.len(), 1, "{bodies:?}");
            let OtherBody { bounds, gap } = bodies[0];
            assert!((bounds.size().x - 2.0 * half(15.0, 0.25)).abs() < 0.02, "{bounds:?}");
            assert!(gap > 0.14 && gap < 0.18, "{gap}");
            let joined = points(&[two()], table, 0.18);
            assert_eq!(
                other_bodies(&joined, &[two()], table.find(&[two()], never).unwrap(), never).unwrap(),
                []
            );
        }
    }

    /// Pixels to metres at this height.
    fn half(pixels: f64, height: f64) -> f64 {
        (pixels + 0.5) * 0.01 * (1.0 - height)
    }

    #[test]
    fn the_object_is_the_nearest_thing_and_neither_clutter_nor_ground() {
        for table in [Table::None, Table::AtHeight(0.0), Table::Fitted] {
            let scene = frame(|u, v| match () {
                _ if square(u, v, (0, 0), 10) => 0.3,
                _ if square(u, v, (80, 0), 5) => 0.4,
                _ => 0.0,
            });
            let bounds = bounds(&[scene], table).unwrap();
            assert!((bounds.min.z - 0.3).abs() < 1e-6 && (bounds.max.z - 0.3).abs() < 1e-6, "{bounds:?}");
            assert!((bounds.size().x - 2.0 * half(10.0, 0.3)).abs() < 0.02, "{bounds:?}");
        }
    }

    #[test]
    fn an_object_beside_the_middle_is_nearer_than_the_wall() {
        let scene = frame(|u, v| if square(u, v, (70, 70), 10) { 0.6 } else { 0.0 });
        let bounds = bounds(&[scene], Table::None).unwrap();
        assert!(bounds.min.z > 0.5 && bounds.center().x.abs() > 0.2, "{bounds:?}");
    }

    #[test]
    fn later_frames_add_what_hangs_together() {
        let small = || frame(|u, v| if square(u, v, (0, 0), 10) { 0.3 } else { 0.0 });
        let apart = frame(|u, v| if square(u, v, (60, 0), 10) { 0.3 } else { 0.0 });
        let bridge = frame(|u, v| if square(u, v, (30, 0), 30) { 0.3 } else { 0.0 });
        let table = Table::AtHeight(0.0);
        let first = bounds(&[small()], table).unwrap();
        assert_eq!(bounds(&[small(), apart.clone()], table).unwrap(), first);
        let both = bounds(&[small(), apart, bridge], table).unwrap();
        assert!(both.size().x > 2.5 * first.size().x, "{both:?}");
    }

    #[test]
    fn a_few_points_or_only_the_table_are_no_object() {
        assert_eq!(bounds(&[frame(|_, _| 0.0)], Table::AtHeight(0.0)), None);
        assert_eq!(bounds(&[frame(|_, _| 0.001)], Table::AtHeight(0.0)), None);
        assert_eq!(bounds(&[frame(|_, _| f64::NEG_INFINITY)], Table::None), None);
        let speck = frame(|u, v| if square(u, v, (0, 0), 1) { 0.3 } else { 0.0 });
        assert_eq!(bounds(&[speck], Table::AtHeight(0.0)), None);
    }
}
